// A true IMU on a motion -> a recording.
//
//   const motion::Trajectory flown = motion::flight(start, segments);
//   const Recording recording = simulate_motion(motion::ideal_increments(flown, 0.01), 0.01, truth, seed);
#pragma once

#include "imulab/navigate.hpp"
#include "imulab/navigation/motion/mission.hpp"
#include "imulab/simulate.hpp"

#include <cstdint>
#include <optional>
#include <vector>

namespace imulab {

/// The output of the IMU where a perfect one reads `ideal`, each over `interval` [s]: raw readings of the mean motion over the sample, with its noise
/// terms. Gravity and latitude are the motion's. With a temperature its zeros drift, and the recording has a thermal reading for each axis. Throws
/// Error for an IMU with lever arms, since the increments are those of one point, and for one with thermal terms without a temperature or with
/// readings in another unit.
Recording simulate_motion(const std::vector<Increment>& ideal, double interval, const Truth& unit, std::uint64_t seed,
                          const std::optional<motion::UnitTemperature>& temperature = {});

}  // namespace imulab
