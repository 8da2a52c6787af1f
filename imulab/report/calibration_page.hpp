// A calibration as a page: verdict, pictures of its effect and its data, and the certificate.
#pragma once

#include "imulab/estimate/method.hpp"
#include "imulab/recording/session.hpp"
#include "imulab/report/evidence.hpp"

#include <optional>
#include <string>
#include <vector>

namespace imulab {

struct CalibrationReport {
  CalibrationResult result;  ///< of a saved calibration: the calibration alone
  std::optional<Session> session = {};
  std::vector<RecordingEvidence> recordings = {};
  std::vector<std::string> missing = {};  ///< pictures that could not be drawn, and why
};

/// HTML, self-contained.
std::string calibration_page(const CalibrationReport& report);

}  // namespace imulab
