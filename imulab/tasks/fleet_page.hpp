// A fleet as a page.
#pragma once

#include "imulab/fleet.hpp"

#include <string>
#include <vector>

namespace imulab {

/// HTML, self-contained: the spread of each coefficient and the units in the order of their times, outliers, histories, due units, stations,
/// correlations. `links`: where each unit's own page is, by unit; empty, or one empty: no link.
std::string fleet_page(const FleetStatistics& statistics, const std::string& title, const std::vector<std::string>& links = {});
/// The units that a page names: its outliers, drifting units and those that are due first.
std::vector<Eigen::Index> units_on_page(const FleetStatistics& statistics);

}  // namespace imulab
