// Calibrations that may be applied, and the recordings that they fit.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/session.hpp"

#include <string>
#include <vector>

namespace imulab {

/// Throws Error, with `name` in front, where a coefficient is beyond any size with which one can compute.
void expect_sizes(const Calibration& calibration, const std::string& name);

/// The warning of a doubtful calibration, with `name` in front; of any other nothing.
std::vector<std::string> doubt_about(const Calibration& calibration, const std::string& name);

/// Expects a calibration that may be applied. Returns the warnings, with `name` in front: doubt_about; triads taken as declared; where it is
/// `allowed`, also offsets or matrices that the data did not determine, which keep starting values that compensate nothing. Throws Unsupported with
/// these where they are not allowed; `allow` says how to allow them. Throws Error as expect_sizes.
std::vector<std::string> expect_usable(const Calibration& calibration, const std::string& name, bool allowed,
                                       const std::string& allow = "--allow-undetermined");

/// The recording named `name`, or the only one. Throws Error that lists them.
const RecordingSource& choose_recording(const Session& session, const std::string& name = "");

/// Throws Error where a temperature is in another unit than in the calibration.
void check_thermal_units(const Calibration& calibration, const RecordingSource& source);

}  // namespace imulab
