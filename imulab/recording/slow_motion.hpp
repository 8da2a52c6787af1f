// Motion too slow to show within the windows in which rests are found.
#pragma once

#include "imulab/recording/recording_view.hpp"

#include <vector>

namespace imulab {

/// The parts of a range between slow motion: where the mean of a reading over a second changes by more than twenty times as usual, and by more than
/// two steps of the readings. Normally distributed noise and drift do not; readings that jump now and then (popcorn noise) may. Only the range itself
/// where it is shorter than ten seconds.
std::vector<Range> between_slow_motion(const RecordingView& recording, const Range& range);

}  // namespace imulab
