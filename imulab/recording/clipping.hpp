// Channels that clip: a reading at the end of the sensor's range says only that the true value lies beyond.
#pragma once

#include "imulab/recording/recording_view.hpp"

#include <cstddef>
#include <functional>
#include <vector>

namespace imulab {

/// The samples at which a channel stands at its largest or its smallest value because it clips there, ascending. A value at which the readings pile
/// up is taken for a limit: of readings that hardly ever repeat one that occurs three times, of readings in steps one that occurs three times as
/// often as each of the three steps next to it and stays three times longer than any other (ten times where nine of ten readings repeat the one
/// before anyway: without noise, a table at rest repeats its readings too), unless the readings came to it by steps as at a rest. (The tail of a
/// normal distribution thins out toward its end.)
std::vector<std::size_t> clipped_samples(const std::vector<double>& channel);
/// Finds the clipped samples in a range of a column: calls `each` with them, ascending.
void for_each_clipped(const RecordingView& recording, std::size_t column, const Range& range, const std::function<void(std::size_t)>& each);

}  // namespace imulab
