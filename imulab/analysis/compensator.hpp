// A recording that comes in pieces, compensated as it comes.
#pragma once

#include "imulab/analysis/compensate_recording.hpp"
#include "imulab/model/outlier_filter.hpp"

#include <optional>

namespace imulab {

class Compensator {
 public:
  Compensator(SensorModel model, Outliers outliers);

  /// Takes the next samples. Where outliers are rejected two samples less have come out than were taken, until rest().
  CompensatedRecording next(Recording piece);
  /// At the end.
  CompensatedRecording rest();

 private:
  SensorModel model_;
  std::optional<OutlierFilter> filter_;
  Recording held_;  // the samples that are still in the filter
};

}  // namespace imulab
