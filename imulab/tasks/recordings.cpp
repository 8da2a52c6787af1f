#include "imulab/tasks/recordings.hpp"

#include "imulab/core/error.hpp"
#include "imulab/io/text/names.hpp"

#include <fmt/format.h>

#include <string_view>
#include <vector>

namespace imulab {

const RecordingSource& choose_recording(const Session& session, const std::string& name) {
  std::vector<std::string_view> files;
  for (const RecordingSource& source : session.recordings) {
    if (source.file == name || (name.empty() && session.recordings.size() == 1)) return source;
    files.push_back(source.file);
  }
  if (files.empty()) throw Error(session.file + ": has no recordings; expected at least one [[recording]]");
  throw Error(fmt::format("{}: {}; expected one of {}", session.file, name.empty() ? "has several recordings" : "has no recording " + name,
                          text::listed(files)));
}

}  // namespace imulab
