// The white noise of an IMU in the rests of its calibration: for filters whose noise nobody has measured otherwise.
#pragma once

#include "imulab/calibrate.hpp"

#include <optional>

namespace imulab::kernel {

/// Pooled over the rests that the fit used; of a method that does not list them, those of its input. Absent where there are none.
std::optional<RestNoise> rest_noise(const Calibration& calibration, const CalibrationInput& input);

}  // namespace imulab::kernel
