// Compensated recordings: counts, and what a picture shows of them.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/model/conclusion.hpp"
#include "imulab/recording/overview.hpp"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace imulab {

/// One that was written.
struct CompensatedFile {
  std::string file;  ///< as it was named on the command line
  std::size_t samples = 0, saturated = 0, out_of_range = 0, replaced = 0;
  std::string recording = {};  ///< the file that it was made of
  double rate_hz = 0;
  std::size_t gaps = 0;
  std::optional<Overview> overview = {};  ///< absent: of a stream
};

struct CompensationSummary {
  std::string calibration_file;
  std::string imu;  ///< the calibration's
  Quality quality;  ///< of the calibration; from JSON: verdict and reasons alone
  std::vector<CompensatedFile> files;
};

/// {"files": [{"file", "samples", ...}], "calibration": {...}} (docs/reference/compensate.md).
std::string compensation_json(const CompensationSummary& summary);

/// Doubtful where samples or the calibration have a reservation.
Conclusion conclusion_of(const CompensationSummary& summary);

}  // namespace imulab
