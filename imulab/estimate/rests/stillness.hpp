// Rests with motion: a hand trembles, a body wanders, and a rest found in the data contains the ends of the adjacent turns. The gyros measure the
// rotation from a rest's middle to its edges; a test on the data decides whether it is used.
#pragma once

#include "imulab/navigation/integration/integrated_rotation.hpp"
#include "imulab/recording/rest_means.hpp"
#include "imulab/recording/scaling.hpp"

#include <span>
#include <vector>

namespace imulab::rests {

/// The ends of rests that count as part of the adjacent turns. A rest found in the data contains the slow ends of turns, which have a common sign, so
/// that ignoring them biases every scale factor. If the gyros measure more motion, the whole rest counts, up to its middle.
struct Stillness {
  std::size_t end = 0;  ///< number of samples, at most half a rest
  bool moves = false;   ///< the motion counts up to the middle
  double wander = 0;    ///< [rad], RMS per axis beyond the noise, from the middle to such an end
};

/// Judges the gyro integrals from the middles to the ends, minus the rate that an offset and a g-sensitivity explain, by their size relative to the
/// noise, and by their components along the adjacent turns, whose signs would otherwise be random. `sample_sigma` and `rounding_sigma` are noise of
/// scaled gyro samples, and of a rest's mean due to rounding.
Stillness stillness_of(const Recording& recording, std::span<const RestMeans> rests, const SensorModel& scaled_model, const Scaling& scaling,
                       const Vector3d& sample_sigma, const Vector3d& rounding_sigma);

/// Returns the samples of the turn between two rests, including the ends of the rests unless they have a gap. Adjacent rests have no turn.
Range turn_between(const Recording& recording, Range rest, Range next, const Stillness& stillness);

/// Refers the mean forces to the axes at the middles of the rests: rotates each sample by the gyro integral up to it.
void level_at_middle(const Recording& recording, std::vector<RestMeans>& rests, const SensorModel& scaled_model, const Scaling& scaling);

}  // namespace imulab::rests
