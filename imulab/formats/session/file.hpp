// Session files: TOML <-> Session (docs/formats.md).
#pragma once

#include "imulab/recording/session.hpp"

#include <filesystem>
#include <string>
#include <string_view>

namespace imulab {

/// Reads a session or a procedure: a folder with session.toml, or the file. Units become SI, absent angles are filled in, a procedure's steps are
/// laid out in time. Throws Error with file, line and key: for unknown keys and units, values out of range, and steps that overlap.
Session read_session(const std::filesystem::path& path);
/// Reads a session from text; `file` is its name in messages, and files that it names are beside it.
Session parse_session(std::string_view text, const std::string& file);

/// The session as TOML text that read_session reads back to the same values.
std::string session_text(const Session& session);
/// Writes that text, whole or not at all. Throws Error where the file cannot be written.
void write_session(const std::filesystem::path& path, const Session& session);

/// The session as text with durations in place of times where read_session computes the same times: the form that a procedure's author edits.
std::string procedure_text(const Session& session);

/// Densities and terms of an analysis (noise.json) where the IMU declares none. Throws Error as read_noise and noise_sizes do.
void take_noise(ImuDeclaration& imu, const std::string& file);

/// The path of a file that the session names: relative to the session's own folder.
std::filesystem::path session_path(const Session& session, const std::string& file);

}  // namespace imulab
