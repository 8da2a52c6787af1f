// What the `calibrate` verb is made of.
#pragma once

#include "imulab/estimate/hybrid.hpp"

#include <string>

namespace imulab::command {

struct CalibrateArguments {
  std::string session, method, output, terms = "auto", recording, curves;
  bool json = false, stepwise = false;
};

/// Calibrates a session and writes the files that are named. Throws as the estimators do. Of a method other than hybrid the result is the calibration
/// alone.
HybridResult calibrate(const CalibrateArguments& arguments);

/// The table for people; with a coarse model it shows what became of it (Cheng 2014 table 1).
void print_calibration(const Calibration& calibration, const SensorModel* coarse = nullptr);

/// Convergence curves as CSV: time, then residual and sigma of every coefficient.
std::string curves_text(const HybridResult& result);

}  // namespace imulab::command
