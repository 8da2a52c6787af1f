// The numbers of all calibrations of a store, one after the other in little memory.
#pragma once

#include "imulab/fleet/store/numbers.hpp"
#include "imulab/fleet/store/store.hpp"

#include <functional>
#include <string_view>
#include <vector>

namespace imulab::fleet {

/// Of calibrations that were not removed, in the order in which they were added: `sink` gets the calibration, its coefficients and their packed
/// numbers (numbers.hpp), which are there until it returns. Throws Error where a row is damaged.
void each_numbers(FleetStore& store, const std::function<void(std::int64_t, const std::vector<CoefficientIndex>&, std::string_view)>& sink);

/// Of one calibration.
Numbers numbers_of(FleetStore& store, std::int64_t calibration);

/// One row per calibration: its origin, and each coefficient with its standard uncertainty, SI. CSV with a header.
std::string fleet_csv(FleetStore& store);

}  // namespace imulab::fleet
