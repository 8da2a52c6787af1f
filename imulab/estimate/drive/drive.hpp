// Calibration from a drive or flight: the errors of the sensors as an aided navigation finds them (docs/theory/drive.md).
#pragma once

#include "imulab/calibrate.hpp"
#include "imulab/estimate/method.hpp"

namespace imulab::drive {

/// Offsets, matrices and g-sensitivity from one recording in SI and the records of the session's aids, smoothed under the priors of the unit's grade
/// (mems where none is declared). Frame: accelerometers. Every coefficient is stated; those of which the drive says less than the prior are named as
/// considered. Throws Error where the session has no aids, a record is missing or does not overlap the recording, and for readings in counts.
CalibrationResult calibrate(const CalibrationInput& input, const CalibrationOptions& options);

}  // namespace imulab::drive
