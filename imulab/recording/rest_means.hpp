// The means of a recording's rests, and the noise of its samples there.
#pragma once

#include "imulab/eigen.hpp"
#include "imulab/recording.hpp"

#include <cstddef>
#include <span>
#include <vector>

namespace imulab {

/// The readings of one sample.
inline Vector3d reading_at(const Columns3& triad, std::size_t i) { return {triad[0][i], triad[1][i], triad[2][i]}; }

/// One rest: means of the raw readings.
struct RestMeans {
  Range range;
  double mid_s = 0;  ///< middle of the rest, s of the recording's clock
  Vector3d accel = Vector3d::Zero(), gyro = Vector3d::Zero();
  double begin_s = 0, end_s = 0;  ///< of its first and last sample
};

/// Rests without the ends of the turns beside them, which those that were found in the data contain: where in its outer quarters the mean rate of 50
/// ms departs by five standard deviations from that of the rest's middle half, the rest begins or ends a tenth of a second inside.
std::vector<Range> without_ends_of_turns(const Recording& recording, std::vector<Range> rests);

std::vector<RestMeans> summarize_rests(const Recording& recording, const std::vector<Range>& ranges);

/// Returns true if rest k is the one before it, cut as its temperature changed: adjacent, without a gap, in the same attitude. Its readings drift,
/// which is no motion.
bool continues_rest(const Recording& recording, std::span<const RestMeans> rests, std::size_t k);
/// Returns true for a part of a longer rest.
bool is_part_of_rest(const Recording& recording, std::span<const RestMeans> rests, std::size_t k);

/// Mean of all rests' gyro readings.
Vector3d mean_gyro(const std::vector<RestMeans>& rests);

/// The least and the largest accelerometer reading of each axis.
struct Extremes {
  Vector3d low, high;
};
Extremes accel_extremes(const std::vector<RestMeans>& rests);

/// Standard deviation of one sample at rest, per axis, raw.
struct SampleNoise {
  Vector3d accel = Vector3d::Zero(), gyro = Vector3d::Zero();
};

/// Pooled over the rests, about each rest's own mean.
SampleNoise measure_noise(const Recording& recording, const std::vector<RestMeans>& rests);

/// Standard deviation of one axis's samples in the median block of the rests, of `block` samples, so that disturbances of some do not count; infinite
/// where no rest is that long.
double quiet_noise(const std::vector<double>& readings, const std::vector<Range>& rests, std::size_t block);

}  // namespace imulab
