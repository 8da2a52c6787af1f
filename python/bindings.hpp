// The parts of the module, one a source file, and what they share.
#pragma once

#include "imulab/estimate/method.hpp"
#include "imulab/recording/make_recording.hpp"
#include "imulab/tasks/calibrate.hpp"

#include "python/arrays.hpp"
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace imulab::python {

/// A calibration, and what it was made from where that is known.
struct CalibrationObject {
  std::shared_ptr<const CalibrationResult> result;
  std::shared_ptr<const SessionRecordings> data;  ///< null for one from a file

  const Calibration& calibration() const { return result->calibration; }
};

/// The answer of any verb, as the command gives it.
struct Outcome {
  std::string json, text;
  std::string shortcomings = {};  ///< why it is not what was asked for; empty: it is
  std::vector<std::string> warnings = {};
  std::function<std::string()> page = {};  ///< HTML
  std::map<std::string, py::array> arrays = {};
};

/// A triad's options from the keys that the Python side passes.
ReadingOptions reading_options(const py::dict& given, const std::string& triad);

void bind_recording(py::module_& module);
void bind_session(py::module_& module);
void bind_calibration(py::module_& module);
void bind_estimates(py::module_& module);
void bind_navigation(py::module_& module);
void bind_fleets(py::module_& module);
void bind_live(py::module_& module);

}  // namespace imulab::python
