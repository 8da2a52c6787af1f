// Samples that a line or a logger lost, one or two at a time, between others that it did not lose.
#pragma once

#include "imulab/recording/recording_view.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace imulab {

struct FilledRecording {
  Recording recording;
  std::size_t filled = 0;  ///< samples
};

/// Fills gaps of one or two samples with the cubic through the two neighbors on each side, where these have neither a gap nor a saturated sample
/// among them. For motion of frequency f and interval T the error is (2 pi f T)^4 / 6 of the amplitude with one lost sample, / 2 with two: 4e-5
/// and 1.2e-4 at 2 Hz and 100 Hz. Other gaps stay. Nothing is filled where more than a tenth of all samples would be.
FilledRecording with_short_gaps_filled(Recording recording);

/// What it inserts, for columns that are not in memory.
struct ShortGaps {
  std::vector<std::size_t> counts;  ///< samples before each of the recording's gaps
  std::size_t filled = 0;           ///< their sum; 0 where nothing is to be filled
};
ShortGaps short_gaps(const RecordingView& recording);
/// Sample k, from 1, of `count` between the second and the third of four neighbors.
double filled_sample(std::span<const double, 4> neighbors, std::size_t count, std::size_t k);
/// Its stamp, between those of two neighbors.
std::int64_t filled_stamp(std::int64_t before_ns, std::int64_t after_ns, std::size_t count, std::size_t k);
/// Gaps and saturated samples where the samples are inserted.
struct FilledMarks {
  std::vector<std::size_t> gaps, saturated;
};
FilledMarks filled_marks(const RecordingView& recording, const ShortGaps& inserted);

}  // namespace imulab
