#include "imulab/model/calibration.hpp"

#include <algorithm>
#include <cmath>

namespace imulab {

std::optional<double> standard_uncertainty(const Calibration& calibration, int index) {
  const auto& estimated = calibration.estimated;
  const auto found = std::find(estimated.begin(), estimated.end(), index);
  if (found == estimated.end()) return std::nullopt;
  const auto i = found - estimated.begin();
  return std::sqrt(calibration.covariance(i, i));
}

}  // namespace imulab
