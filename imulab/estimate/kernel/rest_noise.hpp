// White noise of an IMU in the rests of its calibration, for filters that have no better noise measurement.
#pragma once

#include "imulab/calibrate.hpp"

#include <optional>

namespace imulab::kernel {

/// Pools the noise over the rests that the fit used, or over the rests of the input if the method does not list them. Absent without rests.
std::optional<RestNoise> rest_noise(const Calibration& calibration, const CalibrationInput& input);

}  // namespace imulab::kernel
