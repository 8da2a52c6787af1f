// For tests of the methods: an input that owns what it refers to.
#pragma once

#include "imulab/estimate/method.hpp"

#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace imulab {

/// Of one recording, which outlives it as the session does.
inline CalibrationInput input_of(const Session& session, const Recording& recording, std::optional<std::vector<Range>> rests = {}) {
  return {session, {&recording, 1}, std::move(rests)};
}

/// By a method on rests, of a unit and a site that are all that is declared.
inline Calibration calibrated(std::string_view method, const Recording& recording, const std::vector<Range>& rests, const ImuDeclaration& imu,
                              const Site& site, const CalibrationOptions& options = {}) {
  Session session;
  session.imu = imu;
  session.site = site;
  return calibrate(method, input_of(session, recording, rests), options).calibration;
}

}  // namespace imulab
