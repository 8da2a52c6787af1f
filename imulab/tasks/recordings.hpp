// Which of a session's recordings.
#pragma once

#include "imulab/recording/session.hpp"

#include <string>

namespace imulab {

/// The one named `name`, or the only one. Throws Error that lists them.
const RecordingSource& choose_recording(const Session& session, const std::string& name = "");

}  // namespace imulab
