// For tests of the methods: an input that owns what it refers to.
#pragma once

#include "imulab/calibrate.hpp"
#include "imulab/estimate/method.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace imulab {

/// The input of one recording, which outlives it as the session does.
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

/// Errors in sigmas, the largest.
inline double largest_sigmas(const Calibration& c, const SensorModel& truth) {
  double largest = 0;
  for (const CoefficientIndex index : c.estimated)
    largest = std::max(largest, std::abs(coefficient_value(c.model, index) - coefficient_value(truth, index)) / *standard_uncertainty(c, index));
  return largest;
}

}  // namespace imulab
