// The noise of samples at rest, where some of the rests are disturbed.
#pragma once

#include "imulab/recording/recording.hpp"

#include <cstddef>
#include <vector>

namespace imulab {

/// Standard deviation of one axis's samples in the median block of the rests, of `block` samples, so that disturbances of some do not count; infinite
/// where no rest is that long.
double quiet_noise(const std::vector<double>& readings, const std::vector<Range>& rests, std::size_t block);

}  // namespace imulab
