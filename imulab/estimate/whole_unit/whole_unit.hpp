// Whole-unit calibration (docs/theory/whole-unit.md): thermal chamber, rate table and centrifuge determine up to 57 independent coefficients (Dai
// 2011 section 3 counts 63 including the thermal constants, which the gauge c0 = d0 = 0 at T0 fixes), jointly by weighted least squares or in Dai's
// three steps.
#pragma once

#include "imulab/calibrate.hpp"
#include "imulab/estimate/method.hpp"

namespace imulab::whole_unit {

/// Calibrates from all recordings of the session; the frame is "rig". Machines may be missing: coefficients that only they determine keep their
/// starting value and are listed. Throws Unsupported if nothing can be determined, and Error if a mount, unit or direction contradicts the data.
CalibrationResult calibrate(const CalibrationInput& input, const CalibrationOptions& options = {});

/// Predicts the standard uncertainties of the joint estimate for a procedure on machines and an ideal IMU with the declared noise
/// (docs/theory/strapdown.md). Throws like calibrate, and throws Error if no noise is declared.
Prediction predict(const Session& procedure, const PredictionOptions& options = {});

}  // namespace imulab::whole_unit
