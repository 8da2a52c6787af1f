// A whole recording compensated.
#pragma once

#include "imulab/model/sensor_model.hpp"
#include "imulab/recording/recording.hpp"

#include <cstddef>
#include <vector>

namespace imulab {

struct CompensatedRecording {
  Recording recording;                    ///< rates [rad/s] and specific forces [m/s^2] in place of raw readings; the other columns as they were
  std::vector<std::size_t> out_of_range;  ///< samples with a temperature outside the calibrated range, ascending
  std::vector<std::size_t> replaced;      ///< samples with an outlier that was replaced, ascending
};

/// Whether outliers among the raw readings are replaced first (model/outlier_filter.hpp); thermal readings never are.
enum class Outliers { keep, reject };

/// Throws Error where the model needs a temperature that the recording lacks, where the recording's units are not those of the model, and where a
/// reading has no finite compensation.
CompensatedRecording compensate(const SensorModel& model, Recording recording, Outliers outliers = Outliers::keep);

/// Brings the forces of a compensated recording from each accelerometer's place (row i of `lever_arm` [m]) to the body's origin, with the angular
/// acceleration from the samples before and after; one-sided at a gap and at the ends.
void remove_lever_arms(Recording& recording, const Matrix3d& lever_arm);

}  // namespace imulab
