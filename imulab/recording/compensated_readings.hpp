// Readings of a recording, compensated where they are read.
#pragma once

#include "imulab/compensate.hpp"
#include "imulab/outlier_filter.hpp"
#include "imulab/recording.hpp"
#include "imulab/recording/rest_means.hpp"
#include "imulab/sensor_model.hpp"

#include <cstddef>
#include <optional>
#include <vector>

namespace imulab {

class CompensatedReadings {
 public:
  /// Both must outlive it.
  CompensatedReadings(const Recording& recording, const SensorModel& model) : recording_(recording), model_(model) {}

  /// The rate [rad/s] or force [m/s^2] of sample i. Samples are read in order, with a few steps back. Throw Error as `compensate` does.
  Vector3d rate(std::size_t i) {
    take(i);
    return reading_at(part_.gyro, i - begin_);
  }
  Vector3d force(std::size_t i) {
    take(i);
    return reading_at(part_.accel, i - begin_);
  }

 private:
  void take(std::size_t i) {
    if (i < begin_ || i - begin_ >= part_.size()) take_part_with(i);
  }
  void take_part_with(std::size_t i);

  const Recording& recording_;
  const SensorModel& model_;
  Recording part_;  // its samples from begin_ on
  std::size_t begin_ = 0;
};

}  // namespace imulab
