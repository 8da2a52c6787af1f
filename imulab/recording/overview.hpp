// A recording thinned to what a picture can show, compensated on the way.
#pragma once

#include "imulab/recording/recording_view.hpp"
#include "imulab/sensor_model.hpp"

#include <cstddef>
#include <vector>

namespace imulab {

/// Smallest and largest reading of each of many intervals: no spike of a single sample is lost.
struct Overview {
  double first_s = 0;                    ///< stamp of the first sample
  std::vector<double> time;              ///< s: two points an interval, or every sample where there are few
  Columns3 rate, force;                  ///< rad/s, m/s^2: of each pair the extremes, the one that came first in front
  Columns3 temperature;                  ///< the accelerometers' or else the gyros' readings, in their unit; empty where there are none
  std::size_t samples_per_interval = 1;  ///< 1: every sample
};

/// At most 2 `intervals` points. Throws Error as `compensate` does.
Overview overview(const SensorModel& model, const RecordingView& recording, std::size_t intervals);

/// The samples of a range, compensated. Throws Error where the model needs a temperature that the recording lacks.
struct MotionSamples {
  Columns3 rate, force;  ///< rad/s, m/s^2
};
MotionSamples compensated_samples(const SensorModel& model, const RecordingView& recording, const Range& range);

}  // namespace imulab
