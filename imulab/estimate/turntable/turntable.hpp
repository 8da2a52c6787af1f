// Turntable calibration (docs/theory/turntable.md): both triads from the holds' means and the turns' sums of any procedure, by generalized least
// squares with the table's declared errors in the weights and in the stated uncertainties.
#pragma once

#include "imulab/calibrate.hpp"
#include "imulab/estimate/method.hpp"
#include "imulab/rig/table_plan.hpp"

namespace imulab::turntable {

/// Estimates offsets and matrices in the table's frame, and a significant g-sensitivity. Throws Error if there are several recordings, the session
/// declares no turntable, its steps are wrong, or readings have another unit than declared; throws Unsupported if nothing can be determined.
CalibrationResult calibrate(const CalibrationInput& input, const CalibrationOptions& options = {});
/// Calibrates observations in memory.
Calibration calibrate(const TableObservations& seen, const RigDeclaration& rig, const ImuDeclaration& imu, const Site& site,
                      const CalibrationOptions& options = {});

}  // namespace imulab::turntable
