// Turntable calibration (docs/theory/turntable.md): both triads from the holds' means and the turns' sums of any procedure, by generalized least
// squares with the table's declared errors in the weights and in the stated uncertainties.
#pragma once

#include "imulab/calibrate.hpp"
#include "imulab/estimate/method.hpp"
#include "imulab/rig/table_plan.hpp"

namespace imulab::turntable {

/// Offsets and matrices in the table's frame, and g-sensitivity where the data show it. Throws Error for several recordings, where the session
/// declares no turntable, its steps are wrong, or readings are in another unit than declared; Unsupported where nothing can be determined.
CalibrationResult calibrate(const CalibrationInput& input, const CalibrationOptions& options = {});
/// Calibrates observations in memory.
Calibration calibrate(const TableObservations& seen, const RigDeclaration& rig, const ImuDeclaration& imu, const Site& site,
                      const CalibrationOptions& options = {});

}  // namespace imulab::turntable
