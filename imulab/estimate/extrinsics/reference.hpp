// Calibration of an IMU against a better one on the same body: the method `reference`. Any motion will do. The body fit (motion_fit.hpp) gives the
// errors of the IMU,
//
//   y_g = (I + E) w + b + G y_a,   y_a = (I + L) f + c
//
// and the coefficients are W1 = (I + E)^-1, C = -W1 G (I + L), W0 = -W1 (b + G c), A1 = (I + L)^-1, A0 = -A1 c.
#pragma once

#include "imulab/calibrate.hpp"

namespace imulab::extrinsics {

/// Calibrates the IMU of the recordings that do not belong to `options.reference`, in the frame of its accelerometers, under the priors of its grade.
/// Coefficients that the motion shows less than the prior are named as considered. Throws Error if the session does not have two IMUs, one of them
/// the reference, and as estimate_extrinsics does.
CalibrationResult calibrate_by_reference(const CalibrationInput& input, const CalibrationOptions& options);

}  // namespace imulab::extrinsics
