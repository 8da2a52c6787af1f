// A session's recording as every verb with a calibration reads it.
#pragma once

#include "imulab/model/calibration.hpp"
#include "imulab/recording/recording.hpp"
#include "imulab/recording/session.hpp"

namespace imulab::command {

/// Throws Error where a temperature is in another unit than in the calibration.
void check_thermal_units(const Calibration& calibration, const RecordingSource& source);

/// Warns of what was met. Throws Error where a temperature is in another unit than in the calibration.
Recording read_for(const Calibration& calibration, const Session& session, const RecordingSource& source);

}  // namespace imulab::command
