#include "imulab/navigation/motion/mission.hpp"

#include "imulab/core/error.hpp"

#include <fmt/format.h>

namespace imulab::motion {
namespace {

constexpr double most_samples = 1e7, longest = 1e6, bytes_per_sample = 270;  // a row of the recording and one of the truth

void check_size(double duration, double rate) {
  const double samples = duration * rate;
  if (!(samples * (1 + 1e-12) >= 1)) throw Error(fmt::format("{:g} s at {:g} Hz: expected one sample at least", duration, rate));
  if (samples > most_samples * (1 + 1e-12))
    throw Error(fmt::format("{:g} s at {:g} Hz are {:.0f} samples, files of {:.1f} GB: expected at most {:.0f} samples", duration, rate, samples,
                            samples * bytes_per_sample / 1e9, most_samples));
  if (duration > longest) throw Error(fmt::format("{:g} s: expected at most {:g} s", duration, longest));
}

}  // namespace

Trajectory trajectory_of(const Mission& mission) {
  if (mission.track) {
    if (mission.track->size() > 1) check_size(mission.track->time.back() - mission.track->time.front(), mission.rate);
    return track(*mission.track, mission.smoothing);
  }
  double duration = 0;
  for (const Segment& s : mission.segments) duration += s.duration;
  if (!mission.segments.empty()) check_size(duration, mission.rate);
  return flight(mission.start, mission.segments, mission.carrier);
}

}  // namespace imulab::motion
