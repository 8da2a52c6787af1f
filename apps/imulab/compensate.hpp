// Common to the compensation of files and of a stream.
#pragma once

#include "imulab/model/calibration.hpp"
#include "imulab/recording/compensate_recording.hpp"
#include "imulab/recording/session.hpp"

#include <string>

namespace imulab::command {

struct CompensateOptions {
  std::string calibration, session, output, report;
  Outliers outliers = Outliers::keep;
  bool reject_outliers = false, allow_undetermined = false;
  std::string stream_session, recording;  ///< of a stream
};

struct CompensateCounts {
  std::size_t samples = 0, saturated = 0, out_of_range = 0, replaced = 0;
};

/// "out.csv: 100 samples, 0 saturated, 0 outside the calibrated temperatures"; with the outliers if they are rejected.
void print_counts(const std::string& file, const CompensateCounts& counts, Outliers outliers);

/// Standard input to standard output or a file, row by row.
void compensate_stream(const CompensateOptions& options);

}  // namespace imulab::command
