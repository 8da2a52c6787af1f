// Hybrid calibration (docs/theory/hybrid.md): a coarse static solution, then a Kalman filter on the velocity of an IMU that stays in one place (Cheng
// 2014). A table only turns the IMU; its angles are not used.
#pragma once

#include "imulab/calibrate.hpp"
#include "imulab/estimate/method.hpp"

namespace imulab::hybrid {

/// Calibrates one recording. On a declared turntable, the velocity is also zero during turns, otherwise only at rest. The result is in the
/// accelerometers' frame; `coarse` is the coarse solution, as in Cheng's table 1. The convergence curves are those of its errors ba, Ma, bg, Mg
/// (states.hpp). Throws Unsupported if nothing can be determined, and Error if there are several recordings, the site has no latitude, or declared
/// units, signs or axes contradict the data.
CalibrationResult calibrate(const CalibrationInput& input, const CalibrationOptions& options = {});

}  // namespace imulab::hybrid
