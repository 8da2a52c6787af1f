// Whole-unit calibration (docs/theory/whole-unit.md): thermal chamber, rate table and centrifuge -> up to 57 independent coefficients (Dai 2011
// section 3 counts 63 with the thermal constants, which the gauge c0 = d0 = 0 at T0 fixes), jointly by weighted least squares or in Dai's three
// steps.
#pragma once

#include "imulab/calibrate.hpp"
#include "imulab/estimate/method.hpp"

namespace imulab::whole_unit {

/// All recordings of the session together; frame "rig". Machines may be missing: what they would have determined keeps its starting value and is
/// listed. Throws Unsupported where nothing can be determined, Error where a mount, a unit or a direction contradicts the data.
CalibrationResult calibrate(const CalibrationInput& input, const CalibrationOptions& options = {});

/// The standard uncertainties that the joint estimate will state of a procedure of the machines, of an ideal IMU with the declared noise
/// (docs/theory/strapdown.md). Throws as calibrate does, and Error where the noise is not declared.
Prediction predict(const Session& procedure, const PredictionOptions& options = {});

}  // namespace imulab::whole_unit
