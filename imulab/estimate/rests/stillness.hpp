// Rests that are not still: a hand trembles, a body wanders, and a rest that was found in the data contains the ends of the turns beside it. The
// gyros see the rotation from a rest's middle to its edges; whether they are believed, or "it was at rest", the data decide.
#pragma once

#include "imulab/navigation/integration/integrated_rotation.hpp"
#include "imulab/recording/rest_means.hpp"
#include "imulab/recording/scaling.hpp"

#include <span>
#include <vector>

namespace imulab::rests {

/// The ends of the rests that count as part of the turns beside them. A rest that was found in the data contains the turns' slow ends: all of one
/// sign, so that without them every scale factor is wrong. Where the gyros show more than that, all of it counts, to the middle.
struct Stillness {
  std::size_t end = 0;  ///< samples, at most half a rest
  bool moves = false;   ///< to the middle
  double wander = 0;    ///< rad, RMS of each axis beyond the noise, from the middle to such an end
};

/// From the gyros' integrals from the middles to the ends, less the rate that an offset and a g-sensitivity explain: by their size against the noise,
/// and by their parts along the turns beside them, whose signs are even by chance. Of the gyros, scaled: the noise of a sample, and that of a rest's
/// mean by rounded readings.
Stillness stillness_of(const Recording& recording, std::span<const RestMeans> rests, const SensorModel& scaled_model, const Scaling& scaling,
                       const Vector3d& sample_sigma, const Vector3d& rounding_sigma);

/// The samples of the turn between two rests, their ends included where they have no gap.
Range turn_between(const Recording& recording, Range rest, Range next, const Stillness& stillness);

/// Refers the means of the force to the axes at the rests' middles: each sample turned by what the gyros integrate up to it.
void level_at_middle(const Recording& recording, std::vector<RestMeans>& rests, const SensorModel& scaled_model, const Scaling& scaling);

}  // namespace imulab::rests
