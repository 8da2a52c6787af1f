// The readings of a recording that the outlier filter replaces (outlier_filter.hpp): single spikes, as errors of transmission make them.
#pragma once

#include "imulab/recording/recording_view.hpp"

#include <cstddef>
#include <vector>

namespace imulab {

/// A reading, and what the filter makes of it.
struct ReplacedReading {
  std::size_t sample = 0, column = 0;
  double value = 0;
};

/// Returns them in the order of the samples, wherever the columns are. Empty if more than 0.5 % of the samples have one: that is the sensor's noise.
std::vector<ReplacedReading> outliers_of(const RecordingView& recording);

/// Returns the samples that have one, ascending.
std::vector<std::size_t> samples_of(const std::vector<ReplacedReading>& readings);

}  // namespace imulab
