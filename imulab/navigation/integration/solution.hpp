// Attitude, velocity and position over time: the result of navigation, and the reference it is compared with.
#pragma once

#include "imulab/navigation/integration/strapdown.hpp"

#include <cstddef>
#include <vector>

namespace imulab {

struct Solution {
  std::vector<double> time;  // s, ascending
  std::vector<NavigationState> states;
  std::size_t size() const { return time.size(); }
};

}  // namespace imulab
