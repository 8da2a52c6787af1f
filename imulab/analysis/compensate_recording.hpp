// A whole recording compensated.
#pragma once

#include "imulab/model/sensor_model.hpp"
#include "imulab/recording/recording.hpp"

#include <cstddef>
#include <vector>

namespace imulab {

struct CompensatedRecording {
  Recording recording;                    ///< rates [rad/s] and specific forces [m/s^2] instead of raw readings; the rest as it was
  std::vector<std::size_t> out_of_range;  ///< samples with a temperature outside the calibrated range, ascending
  std::vector<std::size_t> replaced;      ///< samples with a reading that was an outlier, ascending
};

/// Whether outliers of the raw readings are replaced first (model/outlier_filter.hpp); thermal readings never are.
enum class Outliers { keep, reject };

/// Throws Error where the model needs a temperature that the recording lacks.
CompensatedRecording compensate(const SensorModel& model, Recording recording, Outliers outliers = Outliers::keep);

}  // namespace imulab
