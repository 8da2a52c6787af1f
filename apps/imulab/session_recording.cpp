#include "apps/imulab/session_recording.hpp"

#include "apps/imulab/command.hpp"
#include "imulab/core/error.hpp"
#include "imulab/formats/recording/reader.hpp"
#include "imulab/formats/session/file.hpp"
#include "imulab/formats/text/terminal.hpp"
#include "imulab/tasks/recordings.hpp"

#include <fmt/core.h>

#include <utility>

namespace imulab::command {

Recording read_for(const Calibration& calibration, const Session& session, const RecordingSource& source) {
  check_thermal_units(calibration, source);
  RecordingReading reading = [&] {
    const Progress progress("reading");
    return read_recording(session, source);
  }();
  for (const auto& text : reading.warnings) warn(text);
  return std::move(reading.recording);
}

const RecordingSource& named_recording(const Session& session, const std::string& name) {
  if (session.recordings.empty()) return choose_recording(session, name);  // which no option would fix
  return errors_at("--recording", [&]() -> const RecordingSource& { return choose_recording(session, name); });
}

}  // namespace imulab::command
