// Rows that repeat the readings of the row before: a logger that had no new ones wrote the last again, with a new stamp.
#pragma once

#include "imulab/recording/recording_view.hpp"

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

/// Samples all of whose readings are those of the sample before, ascending, where chance does not explain them.
struct RepeatedRows {
  std::vector<std::size_t> samples;
  double share = 0;             ///< of the recording's samples
  bool evenly = false;          ///< every so many: the sensor is slower than the log
  bool some_by_chance = false;  ///< the readings are so coarse that a good part of the samples repeats by chance, and nobody can tell which
};

/// Compares the readings of the columns from `first` up to `end` (both triads, or one). By chance two readings in a row are equal where a step of the
/// resolution is not small against the noise. But then samples in which all axes but one or two repeat are more frequent still, and with these the
/// samples that repeat all are weighed. Stretches without any change (an IMU without noise at rest) do not count.
std::optional<RepeatedRows> repeated_rows(const RecordingView& recording, std::size_t first, std::size_t end);

/// The recording without these samples; those of a sensor that is slower than the log get even stamps. Gaps are the caller's to find.
Recording without_samples(Recording recording, const RepeatedRows& repeated);

/// "15.5 % of the rows repeat the readings of the row before ...": what was done about it, or what it does to results.
std::string said_of(const RepeatedRows& repeated, std::string_view of, bool left_out);

}  // namespace imulab
