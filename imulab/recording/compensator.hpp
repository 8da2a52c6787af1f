// Compensation of a recording that arrives in pieces.
#pragma once

#include "imulab/model/outlier_filter.hpp"
#include "imulab/recording/compensate_recording.hpp"

#include <optional>

namespace imulab {

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

}  // namespace imulab
