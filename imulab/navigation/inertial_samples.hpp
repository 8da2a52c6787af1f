// A compensated recording as increments for a navigator, in sequence without gaps.
#pragma once

#include "imulab/navigate.hpp"
#include "imulab/recording.hpp"

#include <functional>
#include <vector>

namespace imulab {

struct InertialSamples {
  double begin = 0;  // start of the first sample's interval [s]
  std::vector<TimedIncrement> steps;
  std::vector<double> time;       // end of each [s]
  std::vector<MissingTime> gaps;  // bridged: rate and force are linear in time from the previous sample to the next
};

/// Calls `each`(increment, its end [s]) for the samples of `range` and those that bridge its gaps. A rate [rad/s] or force [m/s^2] is integrated over
/// the difference of the stamps, an increment output is used directly; both advance time by the difference of the stamps. A gap in increments is
/// bridged by whole samples, as many as the clock implies; in rates by the missing time.
void for_each_increment(const Recording& recording, const Range& range, const std::function<void(const TimedIncrement&, double)>& each);
/// Returns all of them.
InertialSamples inertial_samples(const Recording& recording, const Range& range);

/// Returns the gaps inside the range that inertial_samples would bridge.
std::vector<MissingTime> missing_time(const Recording& recording, const Range& range);

/// Returns the standard deviation of the stamps' differences, without gaps, divided by the nominal interval.
double stamp_jitter(const Recording& recording);

}  // namespace imulab
