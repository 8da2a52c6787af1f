// A calibration as a page: verdict, pictures of its effect and its data, and the certificate.
#pragma once

#include "imulab/calibrate.hpp"
#include "imulab/calibration.hpp"
#include "imulab/recording/agreement_at_rest.hpp"
#include "imulab/recording/overview.hpp"
#include "imulab/session.hpp"

#include <optional>
#include <string>
#include <vector>

namespace imulab {

/// The evidence of one recording for a calibration, ready to be drawn.
struct RecordingEvidence {
  std::string file;
  std::size_t samples = 0, saturated = 0, gaps = 0;
  double rate_hz = 0, duration_s = 0;
  double largest_rate = 0, largest_force = 0;  ///< of any axis, SI
  Overview overview;
  std::vector<GravityAtRest> rests;
  std::vector<TurnError> turns;
  std::vector<RestOverTemperature> sweep;  ///< its rests, if the model has terms over temperature
  std::string without_rests;               ///< why there are none; empty where there are some
};

/// One of the recordings of the calibration's session, which share the points of the charts. Its rests are those of the calibration's residuals
/// where it is the only one, else the session's holds, else those found in the data.
RecordingEvidence evidence_of(const Calibration& calibration, const Session& session, const Recording& recording, std::size_t recordings);

struct CalibrationReport {
  CalibrationResult result;  ///< of a saved calibration: the calibration alone
  std::optional<Session> session = {};
  std::vector<RecordingEvidence> recordings = {};
  std::vector<std::string> missing = {};  ///< pictures that could not be drawn, and why
};

/// HTML, self-contained.
std::string calibration_page(const CalibrationReport& report);

}  // namespace imulab
