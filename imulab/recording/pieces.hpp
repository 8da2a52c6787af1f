// Parts of a recording without gaps and saturated samples.
#pragma once

#include "imulab/recording/recording_view.hpp"

#include <vector>

namespace imulab {

/// The parts of a range between its gaps of at least `shortest_gap_s` and its saturated samples.
std::vector<Range> without_interruptions(const RecordingView& recording, Range range, double shortest_gap_s = 0);

/// The longest of them; empty for an empty range.
Range longest_piece(const RecordingView& recording, const Range& range);

/// When the interval of a gyro sample begins [s].
double start_of_sample(const Recording& recording, std::size_t i);

/// The samples that cover [begin, end]; empty where the recording does not, or is interrupted.
Range samples_covering(const Recording& recording, double begin_s, double end_s);

}  // namespace imulab
