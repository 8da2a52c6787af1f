// Which of a session's recordings, and whether it fits a calibration.
#pragma once

#include "imulab/model/calibration.hpp"
#include "imulab/recording/session.hpp"

#include <string>

namespace imulab {

/// The one named `name`, or the only one. Throws Error that lists them.
const RecordingSource& choose_recording(const Session& session, const std::string& name = "");

/// Throws Error where a temperature is in another unit than in the calibration.
void check_thermal_units(const Calibration& calibration, const RecordingSource& source);

}  // namespace imulab
