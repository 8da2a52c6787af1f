// What `calibrate` and `demo` share.
#pragma once

#include "imulab/model/calibration.hpp"

#include <string>

namespace imulab::command {

struct CalibrateArguments {
  std::string session, method, output, terms = "auto", recording;
  bool json = false;
};

/// Calibrates a session and writes the calibration file, if one is named. Throws as the estimators do.
Calibration calibrate(const CalibrateArguments& arguments);

/// The table for people.
void print_calibration(const Calibration& calibration);

}  // namespace imulab::command
