// The statistics of a fleet whose calibrations are in memory.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/fleet.hpp"
#include "imulab/fleet/statistics/control.hpp"
#include "imulab/fleet/statistics/drift.hpp"
#include "imulab/fleet/statistics/gauge.hpp"
#include "imulab/fleet/statistics/outliers.hpp"
#include "imulab/fleet/statistics/random_effects.hpp"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace imulab {

/// `covariance`: of the calibration in a row, of the sample's `common` columns; NaN where it has none. Works on all processors; the result does not
/// depend on their number.
FleetStatistics fleet_statistics(FleetSample sample, const std::function<Eigen::MatrixXd(Eigen::Index row)>& covariance,
                                 const FleetOptions& options = {});

}  // namespace imulab
