// A true unit carried along a motion -> a recording.
#pragma once

#include "imulab/navigation/increment.hpp"
#include "imulab/simulate/simulate.hpp"

#include <cstdint>
#include <vector>

namespace imulab {

/// What the unit puts out where a perfect one reads `ideal`, each over `interval` [s]: raw readings (means over the samples) with its noise terms. Gravity
/// and latitude are the motion's. Throws Error for a unit with lever arms, since the increments are those of one point.
Recording simulate_motion(const std::vector<Increment>& ideal, double interval, const Truth& unit, std::uint64_t seed);

}  // namespace imulab
