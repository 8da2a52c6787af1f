// For tests of session files: a session's text, read as the file.
#pragma once

#include "imulab/files.hpp"

#include "tests/temporary_folder.hpp"
#include <string>

namespace imulab {

inline const std::string session_head = "format = \"imulab.session/1\"\n";
/// A recording in counts.
inline const std::string session_recording =
    "[[recording]]\n"
    "file = \"r.csv\"\n"
    "time = { column = \"t\", unit = \"s\" }\n"
    "gyro = { columns = [\"gx\", \"gy\", \"gz\"], output = \"rate\", unit = \"count\" }\n"
    "accel = { columns = [\"ax\", \"ay\", \"az\"], output = \"rate\", unit = \"count\" }\n";

inline Session parse_session(const std::string& text) {
  const TemporaryFolder folder;
  return read_session(folder.write("session.toml", text));
}

}  // namespace imulab
