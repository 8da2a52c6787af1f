#pragma once

#include <memory>

namespace sensor_msgs::msg {

struct Temperature {
  using SharedPtr = std::shared_ptr<Temperature>;
  double temperature = 0;
};
inline bool fill(Temperature&, const double*) { return false; }

}  // namespace sensor_msgs::msg
