// Compensated readings of a recording, a thousand at a time: a compensated copy of a long one takes its memory once more.
#pragma once

#include "imulab/recording/compensate_recording.hpp"
#include "imulab/recording/rest_means.hpp"

#include <cstddef>

namespace imulab {

class CompensatedReadings {
 public:
  /// Both must outlive it.
  CompensatedReadings(const Recording& recording, const SensorModel& model) : recording_(recording), model_(model) {}

  /// Of sample i [rad/s], [m/s^2]. They are read in order, with a few steps back. Throw Error as `compensate` does.
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
