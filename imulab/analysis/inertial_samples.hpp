// A compensated recording as what a navigator steps with: increments one after the other, without holes.
#pragma once

#include "imulab/model/sensor_model.hpp"
#include "imulab/navigation/alignment.hpp"
#include "imulab/recording/recording.hpp"

#include <vector>

namespace imulab {

/// Time for which there is no sample.
struct MissingTime {
  double begin = 0, length = 0;  // s
};

struct InertialSamples {
  double begin = 0;  // of the first sample's interval [s]
  std::vector<TimedIncrement> steps;
  std::vector<double> time;       // end of each [s]
  std::vector<MissingTime> gaps;  // bridged: rate and force run straight from the sample before to the one after
};

/// The samples of `range`. A rate lasts for the difference of the stamps, an increment is what it is; both move time on by the stamps' difference.
/// In a gap increments are bridged by whole samples, as many as the clock says, rates by the time that is missing.
InertialSamples inertial_samples(const Recording& recording, const Range& range);

/// The gaps inside the range that inertial_samples would bridge.
std::vector<MissingTime> missing_time(const Recording& recording, const Range& range);

/// Of the stamps' differences but gaps: standard deviation over the nominal interval.
double stamp_jitter(const Recording& recording);

/// Forces brought from each accelerometer's place (row i: r_i [m]) to the body's origin: f_i less the component i of w' x r_i + w x (w x r_i), with
/// w' from the samples before and after.
void remove_lever_arms(Recording& recording, const Matrix3d& lever_arm);

}  // namespace imulab
