// A fleet as a page.
#pragma once

#include "imulab/estimate/fleet/statistics.hpp"

#include <string>

namespace imulab {

/// HTML, self-contained: the spread of each coefficient and the units in the order of their times, outliers, histories, stations, correlations.
std::string fleet_page(const FleetStatistics& statistics, const std::string& title);

}  // namespace imulab
