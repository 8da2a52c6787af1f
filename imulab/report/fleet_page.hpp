// A fleet as a page.
#pragma once

#include "imulab/fleet/statistics.hpp"

#include <string>

namespace imulab {

/// HTML, self-contained: the spread of each coefficient and the units in the order of their times, outliers, histories, stations, correlations. The
/// store gives the units' names.
std::string fleet_page(const FleetStatistics& statistics, FleetStore& store, const std::string& title);

}  // namespace imulab
