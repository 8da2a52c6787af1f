// Turns that were not measured as a whole, though nothing in them says so: a gyro that stuck for a second. The attitude after such a turn is wrong by
// degrees, and no model explains it.
#pragma once

#include "imulab/navigation/in_place/navigator.hpp"
#include "imulab/recording.hpp"
#include "imulab/sensor_model.hpp"

#include <cstddef>
#include <string>
#include <vector>

namespace imulab::hybrid {

/// The blocks of each motion between two rests.
std::vector<Range> motions_of(const std::vector<in_place::Block>& blocks);

/// By how much gravity turns otherwise in a motion than this model's gyros say [rad]. Turns about the vertical do not show.
std::vector<double> misfits_of_gravity(const Recording& recording, const SensorModel& model, const std::vector<in_place::Block>& blocks,
                                       const std::vector<Range>& motions);

/// Without these blocks; the attitude is aligned anew after them.
std::vector<in_place::Block> without(std::vector<in_place::Block> blocks, const Range& motion);
/// The places of blocks when these are taken out.
std::vector<std::size_t> without(std::vector<std::size_t> places, const Range& motion);
/// "the rotation from 12.0 to 15.5 s"
std::string in_words(const Recording& recording, const std::vector<in_place::Block>& blocks, const Range& motion);

}  // namespace imulab::hybrid
