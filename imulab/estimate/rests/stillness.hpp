// Rests that are not still: a hand trembles, a body wanders, and a rest that was found in the data contains the ends of the turns beside it. The
// gyros see the rotation from a rest's middle to its edges; how far they are believed, beside "it was at rest", the data decide.
#pragma once

#include "imulab/navigation/integration/integrated_rotation.hpp"
#include "imulab/recording/rest_means.hpp"
#include "imulab/recording/scaling.hpp"

#include <span>
#include <vector>

namespace imulab::rests {

/// The rotation from a rest's middle to an edge is zero with the standard deviation `wander`, and what the gyros integrate with `noise`: together
/// `weight()` of the latter. Where chance explains all that the gyros show, the wander is zero, and so is the weight.
struct Stillness {
  double wander = 0, noise = 0;  ///< rad, of each axis

  double weight() const { return wander > 0 ? wander * wander / (wander * wander + noise * noise) : 0; }
};

/// From the gyros' integrals over half rests, less the rate that an offset and a g-sensitivity explain. Of the gyros, scaled: the noise of a sample,
/// and that of a rest's mean by rounded readings.
Stillness stillness_of(const Recording& recording, std::span<const RestMeans> rests, const SensorModel& scaled_model, const Scaling& scaling,
                       const Vector3d& sample_sigma, const Vector3d& rounding_sigma);

/// The samples of a rest before and after its middle.
Range first_half(const RestMeans& rest);
Range second_half(const RestMeans& rest);

/// Refers the means of the force to the axes at the rests' middles: each sample turned by `weight` of what the gyros integrate up to it.
void level_at_middle(const Recording& recording, std::vector<RestMeans>& rests, double weight, const SensorModel& scaled_model,
                     const Scaling& scaling);

}  // namespace imulab::rests
