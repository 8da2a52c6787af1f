// The statistics of a fleet, for people and for programs.
#pragma once

#include "imulab/fleet.hpp"

#include <string>

namespace imulab {

/// JSON (docs/start/fleet.md): SI.
std::string fleet_statistics_json(const FleetStatistics& statistics);
/// "gyro.cubic.x, gyro.cubic.y": the coefficients that the statistics leave out, for this reason; empty: none.
inline constexpr const char* left_out_reason = "Left out, since the data show nothing of them and only their prior sets them";
std::string left_out_text(const FleetStatistics& statistics);
/// "2027-03-31", or "not in 20 years".
std::string due_text(const UnitDue& due);
/// A row a coefficient in user units; then outliers, drifts, stations and operators, unsteady production and correlations.
std::string fleet_statistics_text(const FleetStatistics& statistics);

}  // namespace imulab
