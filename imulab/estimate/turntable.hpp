// Turntable calibration (docs/turntable.md): both triads from the holds' means and the turns' sums of any procedure, by generalized least squares
// with the table's declared errors in the weights and in the stated uncertainties.
#pragma once

#include "imulab/estimate/handheld.hpp"
#include "imulab/estimate/table_observations.hpp"

namespace imulab {

struct TurntableOptions : EstimateOptions {
  bool bias_while_turning = false;  ///< true: the gyros' bias in turns is unknown by itself, and W0 is that of the holds alone, as Zhang estimates it
};

/// Throws Error where the session declares no turntable or its steps are wrong, Unsupported where nothing can be determined.
Calibration calibrate_turntable(const Recording& recording, const Session& session, const TurntableOptions& options = {});
Calibration calibrate_turntable(const TableObservations& observations, const RigDeclaration& rig, const ImuDeclaration& imu, const Site& site,
                                const TurntableOptions& options = {});

}  // namespace imulab
