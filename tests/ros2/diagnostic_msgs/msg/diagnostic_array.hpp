#pragma once

#include <cstdio>
#include <rclcpp/rclcpp.hpp>
#include <string>
#include <vector>

namespace diagnostic_msgs::msg {

struct DiagnosticStatus {
  static constexpr unsigned char OK = 0, WARN = 1;
  unsigned char level = OK;
  std::string name, message, hardware_id;
};
struct DiagnosticArray {
  struct {
    rclcpp::Time stamp;
  } header;
  std::vector<DiagnosticStatus> status;
};
inline void print(const DiagnosticArray& all) {
  for (const DiagnosticStatus& status : all.status)
    std::printf("# %d %s; %s: %s\n", status.level, status.name.c_str(), status.hardware_id.c_str(), status.message.c_str());
}

}  // namespace diagnostic_msgs::msg
