// A recording at other instants: even stamps in place of late ones, samples in short gaps, columns of one clock on the stamps of another.
#pragma once

#include "imulab/recording/clock.hpp"
#include "imulab/recording/recording_view.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace imulab {

/// The even clock that is to replace the recording's stamps: if that is wanted, or by itself where they scatter by more than a twentieth of an
/// interval. Throws Error where it is wanted and the stamps do not support it.
std::optional<EvenClock> replacing_clock(const Recording& recording, Stamps wanted);

/// The recording with the stamps of that clock. Increments were divided by the nominal interval: by the clock's instead where that one was not
/// declared, but the median of stamps that scatter.
Recording with_even_stamps(Recording recording, const EvenClock& clock, bool interval_declared = true);

struct FilledRecording {
  Recording recording;
  std::size_t filled = 0;  ///< samples
};

/// Fills gaps of one or two samples with the cubic through the two neighbors on each side, where these have neither a gap nor a saturated sample
/// among them. For motion of frequency f and interval T the error is (2 pi f T)^4 / 6 of the amplitude with one lost sample, / 2 with two: 4e-5
/// and 1.2e-4 at 2 Hz and 100 Hz. Other gaps stay. Nothing is filled where more than a tenth of all samples would be.
FilledRecording with_short_gaps_filled(Recording recording);

/// The samples that it inserts, for columns that are not in memory.
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

/// One value a stamp, and whether the source covers it.
struct Resampled {
  std::vector<std::vector<double>> columns;
  std::vector<char> covered;  ///< not where the source has a gap there, or has not begun or has ended
};

/// Readings as means over the intervals that end at `at` (the first interval and those after gaps have the length `interval_s`). A reading stands for
/// the interval that ends at its own stamp, so what accumulates, an angle or a velocity, is kept. `increment`: readings are sums over their
/// intervals, before and after. Stamps [ns] ascend; a source interval longer than one and a half `source_interval_s` is a gap.
Resampled resample_means(const std::vector<std::int64_t>& time_ns, double source_interval_s, const std::vector<std::vector<double>>& columns,
                         bool increment, const std::vector<std::int64_t>& at, double interval_s);

/// Readings of a slow quantity at `at`: on straight lines between their stamps, and as at the nearest one before the first and after the last.
std::vector<std::vector<double>> interpolate(const std::vector<std::int64_t>& time_ns, const std::vector<std::vector<double>>& columns,
                                             const std::vector<std::int64_t>& at);

}  // namespace imulab
