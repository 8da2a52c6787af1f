// Session files: TOML <-> Session (docs/formats.md).
#pragma once

#include "imulab/recording/session.hpp"

#include <filesystem>
#include <string>

namespace imulab {

/// Reads a session (a folder with session.toml, or the file) or a procedure. Units become SI, angles left out are filled in, a procedure's
/// steps are laid out in time. Throws Error naming file, line, field and what was expected; unknown keys and units are errors.
Session read_session(const std::filesystem::path& path);

/// The session as TOML text that read_session reads back to the same values.
std::string session_text(const Session& session);

/// The same with durations in place of times where read_session lays the steps out alike: what a procedure's author edits.
std::string procedure_text(const Session& session);

/// A file the session names, relative to the session's own folder.
std::filesystem::path session_path(const Session& session, const std::string& file);

}  // namespace imulab
