// A true unit carried along a motion -> a recording.
#pragma once

#include "imulab/navigation/increment.hpp"
#include "imulab/navigation/unit_temperature.hpp"
#include "imulab/simulate/simulate.hpp"

#include <cstdint>
#include <optional>
#include <vector>

namespace imulab {

/// What the unit puts out where a perfect one reads `ideal`, each over `interval` [s]: raw readings of the mean motion over the sample, with its noise
/// terms. Gravity and latitude are the motion's. With a temperature its zeros drift along, and the recording has a thermal reading for each axis. Throws
/// Error for a unit with lever arms, since the increments are those of one point, and for one with thermal terms without a temperature or with
/// readings in another unit.
Recording simulate_motion(const std::vector<Increment>& ideal, double interval, const Truth& unit, std::uint64_t seed,
                          const std::optional<UnitTemperature>& temperature = {});

}  // namespace imulab
