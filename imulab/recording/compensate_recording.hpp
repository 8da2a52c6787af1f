// Compensation of a recording: as a whole, in pieces as it arrives, or some readings at a time.
#pragma once

#include "imulab/model/outlier_filter.hpp"
#include "imulab/model/sensor_model.hpp"
#include "imulab/recording/recording.hpp"
#include "imulab/recording/rest_means.hpp"

#include <cstddef>
#include <optional>
#include <vector>

namespace imulab {

struct CompensatedRecording {
  Recording recording;                    ///< rates [rad/s] and specific forces [m/s^2] in place of raw readings; the other columns as they were
  std::vector<std::size_t> out_of_range;  ///< samples with a temperature outside the calibrated range, ascending
  std::vector<std::size_t> replaced;      ///< samples with an outlier that was replaced, ascending
};

/// Outliers among the raw readings are kept, or replaced first (model/outlier_filter.hpp); thermal readings are always kept.
enum class Outliers { keep, reject };

/// Throws Error where the model needs a temperature that the recording lacks, where the recording's units are not those of the model, and where a
/// reading has no finite compensation.
CompensatedRecording compensate(const SensorModel& model, Recording recording, Outliers outliers = Outliers::keep);

/// Brings the forces of a compensated recording from each accelerometer's place (row i of `lever_arm` [m]) to the body's origin, with the angular
/// acceleration from the samples before and after; one-sided at a gap and at the ends.
void remove_lever_arms(Recording& recording, const Matrix3d& lever_arm);

class Compensator {
 public:
  Compensator(SensorModel model, Outliers outliers);

  /// Takes the next samples. With outlier rejection the output lags by two samples until rest().
  CompensatedRecording next(Recording piece);
  /// At the end.
  CompensatedRecording rest();

 private:
  SensorModel model_;
  std::optional<OutlierFilter> filter_;
  Recording held_;  // the samples that are still in the filter
};

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
