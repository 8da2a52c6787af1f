// The means of a recording's rests, and the noise of its samples there.
#pragma once

#include "imulab/core/rotation.hpp"
#include "imulab/recording/recording.hpp"

#include <vector>

namespace imulab::kernel {

/// One rest: means of the raw readings.
struct Rest {
  Range range;
  double mid_s = 0;  ///< middle of the rest, s of the recording's clock
  Vector3d accel, gyro;
};

std::vector<Rest> summarize_rests(const Recording& recording, const std::vector<Range>& ranges);

/// Standard deviation of one sample at rest, per axis, raw.
struct SampleNoise {
  Vector3d accel, gyro;
};

/// Pooled over the rests, about each rest's own mean.
SampleNoise measure_noise(const Recording& recording, const std::vector<Rest>& rests);

}  // namespace imulab::kernel
