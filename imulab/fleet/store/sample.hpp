// The calibrations of a store, for the statistics of a fleet.
#pragma once

#include "imulab/fleet.hpp"
#include "imulab/fleet/statistics/prior.hpp"
#include "imulab/fleet/statistics/statistics.hpp"
#include "imulab/fleet/store/numbers.hpp"

#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

/// Calibrations that were not removed, of one method or of all (""). Covariances stay in the store: in memory are value and variance of each
/// coefficient (16 bytes; 24 with constant ones) and about 150 bytes a calibration beside them. Throws Error where there is none.
FleetSample load_sample(FleetStore& store, const std::string& method = "");

}  // namespace imulab

namespace imulab::fleet {

// The numbers of all calibrations of a store, one after the other in little memory.

/// The coefficients of each layout of a store, by its number.
using Layouts = std::map<std::int64_t, std::vector<CoefficientIndex>>;
Layouts layouts_of(FleetStore& store);
/// The coefficients of packed numbers. Throws Error where they are not as many.
const std::vector<CoefficientIndex>& expect_numbers(FleetStore& store, const Layouts& layouts, std::int64_t calibration, std::int64_t layout,
                                                    std::string_view data);
/// The coefficients of all layouts, in table order.
std::vector<CoefficientIndex> estimated_by_any(FleetStore& store);

/// Reads the calibrations that were not removed, in the order in which they were added: `sink` gets the calibration, its coefficients and their
/// packed numbers (numbers.hpp), which are there until it returns. Throws Error where a row is damaged.
void each_numbers(FleetStore& store, const std::function<void(std::int64_t, const std::vector<CoefficientIndex>&, std::string_view)>& sink);

/// The numbers of one calibration.
Numbers numbers_of(FleetStore& store, std::int64_t calibration);

/// One row per calibration: its origin, and each coefficient with its standard uncertainty, SI. CSV with a header.
std::string fleet_csv(FleetStore& store);

}  // namespace imulab::fleet
