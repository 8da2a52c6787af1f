// Compensated recordings as a page.
#pragma once

#include "imulab/model/calibration.hpp"
#include "imulab/recording/compensate_recording.hpp"
#include "imulab/report/evidence.hpp"

#include <string>
#include <vector>

namespace imulab {

struct CompensatedEvidence {
  std::string file;
  std::size_t samples = 0, saturated = 0, out_of_range = 0, replaced = 0, gaps = 0;
  double rate_hz = 0;
  Overview overview;
};
/// Of a recording that was compensated.
CompensatedEvidence evidence_of(const CompensatedRecording& compensated);

struct CompensationReport {
  std::string calibration_file;
  Calibration calibration;
  std::vector<CompensatedEvidence> recordings;
};

/// HTML, self-contained.
std::string compensation_page(const CompensationReport& report);

}  // namespace imulab
