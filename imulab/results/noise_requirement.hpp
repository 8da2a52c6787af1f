// Limits on the noise of an IMU: "gyro.N <= 0.1 deg/sqrt(h), accel.B <= 20 ug".
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/noise.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace imulab {

/// The worst of the axes and logs counts: gyro.N is of all three, gyro.x.N of one. A term is judged by the upper end of its 95 % interval, or by its
/// bound where the log does not determine it; the note says so where the interval holds the limit, so that the log does not decide. Throws Error for
/// a figure or a unit that there is not.
std::vector<RequirementResult> assess(const std::vector<NoiseAnalysis>& logs, std::string_view limits);

/// Throws Error where the text is no list of limits on figures: before the work.
void expect_noise_limits(std::string_view limits);

}  // namespace imulab
