// Reading a session's recording for a verb with a calibration.
#pragma once

#include "imulab/model/calibration.hpp"
#include "imulab/recording/recording.hpp"
#include "imulab/recording/session.hpp"

#include <string>

namespace imulab::command {

/// Prints the warnings of reading. Throws Error where a temperature is in another unit than in the calibration.
Recording read_for(const Calibration& calibration, const Session& session, const RecordingSource& source);

/// The recording of that file; the only one if no name is given. Otherwise throws Error that lists them.
const RecordingSource& named_recording(const Session& session, const std::string& name);

}  // namespace imulab::command
