// Calibration from a drive or flight: the errors of the sensors as an aided navigation finds them (docs/theory/aided.md).
#pragma once

#include "imulab/calibrate.hpp"
#include "imulab/estimate/drive/together.hpp"
#include "imulab/estimate/method.hpp"
#include "imulab/predict.hpp"

namespace imulab::drive {

/// Offsets, matrices and g-sensitivity from recordings in SI and the records of the session's aids, smoothed under the priors of the unit's grade
/// (mems where none is declared); each recording is a drive, with states and aids of its own, and their statements of the unit are joined. Frame:
/// accelerometers. Every coefficient is stated; those of which the drives say less than the prior are named as considered. Throws Error where the
/// session has no aids, a record is missing, goes with no recording or does not overlap it, and for readings in counts.
CalibrationResult calibrate(const CalibrationInput& input, const CalibrationOptions& options);

/// A drive as it is joined with others.
Drive drive_of(AidedNavigation navigation, const Recording& recording, const ImuDeclaration& imu);
/// What the drives of the input, navigated under `unit_priors`, say of the unit: the second half of `calibrate`.
CalibrationResult calibration_result(const std::vector<Drive>& drives, const CalibrationInput& input, const CalibrationOptions& options);

/// What calibrate will state of one drive on the motion of the options, by an IMU and aids as the session declares them; the aids have records on the
/// motion's clock. Throws Error where there is no motion or no aid.
Prediction predict(const Session& mission, const PredictionOptions& options);

}  // namespace imulab::drive
