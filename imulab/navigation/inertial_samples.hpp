// A compensated recording as increments for a navigator, one after the other without gaps.
#pragma once

#include "imulab/navigate.hpp"
#include "imulab/recording.hpp"

#include <functional>
#include <vector>

namespace imulab {

struct InertialSamples {
  double begin = 0;  // of the first sample's interval [s]
  std::vector<TimedIncrement> steps;
  std::vector<double> time;       // end of each [s]
  std::vector<MissingTime> gaps;  // bridged: rate and force are linear in time from the sample before to the one after
};

/// Calls `each`(increment, its end [s]) for the samples of `range`, with those that bridge gaps among them. A rate [rad/s], force [m/s^2] is
/// integrated over the difference of the stamps, an increment output is taken as it is; both advance time by the stamps' difference. In a gap
/// increments are bridged by whole samples, as many as the clock says, rates by the missing time.
void for_each_increment(const Recording& recording, const Range& range, const std::function<void(const TimedIncrement&, double)>& each);
/// All of them.
InertialSamples inertial_samples(const Recording& recording, const Range& range);

/// The gaps inside the range that inertial_samples would bridge.
std::vector<MissingTime> missing_time(const Recording& recording, const Range& range);

/// Standard deviation of the stamps' differences, gaps left out, over the nominal interval.
double stamp_jitter(const Recording& recording);

}  // namespace imulab
