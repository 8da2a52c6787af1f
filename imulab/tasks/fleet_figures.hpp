// The pictures of a fleet's page.
#pragma once

#include "imulab/fleet.hpp"

#include <string>
#include <vector>

namespace imulab::report {

/// Serial number of the unit in a row of the sample, or its name; as text.
std::string serial_of_row(const FleetStatistics& f, Eigen::Index row);
/// The rows of the units whose values are beyond the required limit, the farthest first.
std::vector<Eigen::Index> beyond_limit(const FleetStatistics& f, const CoefficientStatistics& c);

/// All units in all coefficients, each in the standard deviations that it should have.
std::string fleet_overview(const FleetStatistics& f);
/// How many units are how far from the mean, with the limits; and the units in the order of their times: with limits in user units, else in standard
/// deviations. Empty where there is no spread.
std::string coefficient_charts(const FleetStatistics& f, const CoefficientStatistics& c);
/// What the colors of these charts mean, and of the histories.
std::string charts_key();
std::string history_key();
/// One unit's calibrations of a coefficient over the years, with two standard uncertainties, and its line.
std::string unit_history(const FleetStatistics& f, const CoefficientStatistics& c, const UnitDrift& u);

}  // namespace imulab::report
