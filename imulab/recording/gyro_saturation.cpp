#include "imulab/recording/gyro_saturation.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace imulab {

GyroSaturation::GyroSaturation(const Recording& recording) {
  if (recording.saturated.empty()) return;
  std::array<double, 3> least, most;
  least.fill(HUGE_VAL), most.fill(-HUGE_VAL);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    auto saturated = recording.saturated.begin();
    for (std::size_t i = 0; i < recording.gyro[axis].size(); ++i) {
      if (saturated != recording.saturated.end() && *saturated == i) {
        ++saturated;
        continue;
      }
      least[axis] = std::min(least[axis], recording.gyro[axis][i]), most[axis] = std::max(most[axis], recording.gyro[axis][i]);
    }
  }
  for (const std::size_t i : recording.saturated)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (recording.gyro[axis].empty() || (recording.gyro[axis][i] >= least[axis] && recording.gyro[axis][i] <= most[axis])) continue;
      samples_.push_back(i);
      break;
    }
}

std::size_t GyroSaturation::in(const Range& range) const {
  const auto begin = std::lower_bound(samples_.begin(), samples_.end(), range.begin);
  return static_cast<std::size_t>(std::lower_bound(begin, samples_.end(), range.end) - begin);
}

}  // namespace imulab
