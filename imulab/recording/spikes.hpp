// Spikes: readings of one or two samples far from those before and after, as errors of transmission make them.
#pragma once

#include "imulab/recording.hpp"

#include <cstddef>

namespace imulab {

/// Removes the samples with a spike on any axis, each of which leaves a gap, and returns their number. A spike is 30 times as far from the mean of
/// its neighbors as readings usually differ, and the two on each side agree to a third of that. Nothing is removed if more than 0.5 % of the samples
/// have one.
std::size_t remove_spikes(Recording& recording);

}  // namespace imulab
