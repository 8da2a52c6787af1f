// Reading a session's recording for a verb with a calibration.
#pragma once

#include "imulab/model/calibration.hpp"
#include "imulab/recording/recording.hpp"
#include "imulab/recording/session.hpp"

#include <filesystem>
#include <string>

namespace imulab::command {

/// Prints the warnings of reading. Throws Error where a temperature is in another unit than in the calibration.
Recording read_for(const Calibration& calibration, const Session& session, const RecordingSource& source);

/// The recording of that file; the only one if no name is given. Otherwise throws Error that lists them.
const RecordingSource& named_recording(const Session& session, const std::string& name);

/// The session's file of a calibration: as `given` (a folder or a file), else where the calibration names it, from here or from the calibration's
/// folder, else beside the calibration; the recorded name where none of these is a file.
std::filesystem::path find_session(const std::string& given, const std::string& calibration_file, const std::string& recorded);

}  // namespace imulab::command
