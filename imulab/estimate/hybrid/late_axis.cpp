#include "imulab/estimate/hybrid/late_axis.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace imulab::hybrid {

std::optional<LateAxis> late_axis(const Data& data, const Iterate& converged) {
  constexpr double fits = 1.5, hopeless = 100;  // as in turns whose ramps are between two samples; as of other data
  LateAxis best{0, 0, HUGE_VAL, scatter_of(data, converged)};
  if (!(best.before > fits && best.before < hopeless)) return std::nullopt;
  for (std::size_t axis = 0; axis < 6; ++axis)
    for (const int samples : {1, -1}) {
      const Recording moved = put_right(data.recording, {axis, samples});
      const Data trial{moved, data.blocks, data.place, data.noise, data.coarse, data.wanted, data.priors};
      if (const double scatter = scatter_of(trial, repeated(trial, converged)); scatter < best.scatter)
        best.axis = axis, best.samples = samples, best.scatter = scatter;
    }
  return best.scatter < 0.5 * best.before ? std::optional(best) : std::nullopt;
}

Recording put_right(Recording recording, const LateAxis& late) {
  std::vector<double>& readings = (late.axis < 3 ? recording.gyro : recording.accel)[late.axis % 3];
  if (readings.empty()) return recording;
  if (late.samples > 0)
    std::shift_left(readings.begin(), readings.end(), 1);  // the last one stays
  else
    std::shift_right(readings.begin(), readings.end(), 1);
  return recording;
}

std::string text_of(const LateAxis& late) {
  return fmt::format("the {} {}'s readings are a sample {} than the others'", "xyz"[late.axis % 3], late.axis < 3 ? "gyro" : "accelerometer",
                     late.samples > 0 ? "later" : "earlier");
}

}  // namespace imulab::hybrid
