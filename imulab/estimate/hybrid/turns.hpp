// Turns that were not measured completely without any sign in the data, for example because a gyro stuck for a second. The attitude after such a turn
// is wrong by degrees, and no model explains it.
#pragma once

#include "imulab/navigation/in_place/navigator.hpp"
#include "imulab/recording.hpp"
#include "imulab/sensor_model.hpp"

#include <cstddef>
#include <string>
#include <vector>

namespace imulab::hybrid {

/// Returns the blocks of each motion between two rests.
std::vector<Range> motions_of(const std::vector<in_place::Block>& blocks);

/// Returns for each motion the angle [rad] between gravity after it and gravity propagated by the gyros, blind to turns about the vertical.
std::vector<double> misfits_of_gravity(const Recording& recording, const SensorModel& model, const std::vector<in_place::Block>& blocks,
                                       const std::vector<Range>& motions);

/// Removes these blocks; the attitude is aligned anew after them.
std::vector<in_place::Block> without(std::vector<in_place::Block> blocks, const Range& motion);
/// Returns the indices of blocks after these have been removed.
std::vector<std::size_t> without(std::vector<std::size_t> places, const Range& motion);
/// Returns "the rotation from 12.0 to 15.5 s".
std::string in_words(const Recording& recording, const std::vector<in_place::Block>& blocks, const Range& motion);

}  // namespace imulab::hybrid
