// Common to the compensation of files and of a stream.
#pragma once

#include "imulab/model/calibration.hpp"
#include "imulab/recording/compensate_recording.hpp"
#include "imulab/recording/session.hpp"
#include "imulab/results/compensation.hpp"

#include <string>
#include <vector>

namespace imulab::command {

struct CompensateOptions {
  std::string calibration, session, output, report;
  std::vector<std::string> declarations;  ///< of a recording without a session
  Outliers outliers = Outliers::keep;
  bool reject_outliers = false, allow_undetermined = false, json = false;
  std::string stream_session, recording;  ///< of a stream
};

/// "out.csv: 100 samples, 0 saturated, 0 outside the calibrated temperatures", with the outliers if they are rejected; or as JSON.
void print_counts(const CompensateOptions& options, const CompensationSummary& summary);

/// Standard input to standard output or a file, row by row.
void compensate_stream(const CompensateOptions& options);

}  // namespace imulab::command
