// Common to the compensation of files and of a stream.
#pragma once

#include "imulab/model/calibration.hpp"
#include "imulab/recording/compensate_recording.hpp"
#include "imulab/recording/session.hpp"

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

/// What was written to a file.
struct CompensateCounts {
  std::string file;
  std::size_t samples = 0, saturated = 0, out_of_range = 0, replaced = 0;
};

/// "out.csv: 100 samples, 0 saturated, 0 outside the calibrated temperatures", with the outliers if they are rejected; or the same as JSON.
void print_counts(const CompensateOptions& options, const std::vector<CompensateCounts>& files);

/// Standard input to standard output or a file, row by row.
void compensate_stream(const CompensateOptions& options);

}  // namespace imulab::command
