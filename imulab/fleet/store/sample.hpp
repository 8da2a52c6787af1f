// The calibrations of a store, for the statistics of a fleet.
#pragma once

#include "imulab/fleet/statistics/prior.hpp"
#include "imulab/fleet/statistics/statistics.hpp"
#include "imulab/fleet/store/store.hpp"

#include <string>

namespace imulab {

/// Calibrations that were not removed, of one method or of all (""). Throws Error where there is none.
FleetSample load_sample(FleetStore& store, const std::string& method = "");

/// The statistics of these. Throws Error where there is none.
FleetStatistics fleet_statistics(FleetStore& store, const FleetOptions& options = {}, const std::string& method = "");

/// The prior that the store's units give for the next one. Throws Error for units with readings of different kinds, and for too few.
FleetPrior fleet_prior(FleetStore& store);

}  // namespace imulab
