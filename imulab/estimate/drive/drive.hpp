// Calibration from a drive or flight: an aided navigation estimates the errors of the sensors (docs/theory/aided.md).
#pragma once

#include "imulab/calibrate.hpp"
#include "imulab/estimate/drive/together.hpp"
#include "imulab/estimate/method.hpp"
#include "imulab/predict.hpp"

namespace imulab::drive {

/// Estimates offsets, matrices and g-sensitivity from recordings in SI and the records of the session's aids, smoothed under the priors of the unit's
/// grade (default mems). Each recording is a drive with states and aids of its own; their results for the unit are combined. The frame is that of the
/// accelerometers. Every coefficient is stated; those about which the drives are less informative than the prior are named as considered. Throws
/// Error if the session has no aids, a record is missing, belongs to no recording or does not overlap it, and for readings in counts.
CalibrationResult calibrate(const CalibrationInput& input, const CalibrationOptions& options);

/// Returns a drive in the form in which drives are combined.
Drive drive_of(AidedNavigation navigation, const Recording& recording, const ImuDeclaration& imu);
/// Returns the combined result for the unit from the drives of the input, navigated under `unit_priors`: the second half of `calibrate`.
CalibrationResult calibration_result(const std::vector<Drive>& drives, const CalibrationInput& input, const CalibrationOptions& options);

/// Predicts the result of `calibrate` for one drive with the motion of the options, by an IMU and aids as declared; the aids have records on the
/// motion's clock. Throws Error if there is no motion or no aid.
Prediction predict(const Session& mission, const PredictionOptions& options);

}  // namespace imulab::drive
