// The files of the verb that runs: what it writes replaces nothing that it reads, and nothing else that it writes.
#pragma once

#include "imulab/session.hpp"

#include <filesystem>
#include <string>

namespace imulab::command {

/// The verb reads this file (a folder: its session.toml; "-": standard input). Throws Error where it also writes it, by whatever name: through
/// links, too.
void will_read(const std::filesystem::path& file);

/// The verb writes this file ("-": standard output), which `option` names. Throws Error where it also reads it, where another option names it, too,
/// and where it is a folder or the truth of a simulated session.
void will_write(const std::string& option, const std::filesystem::path& file);

/// The verb makes this folder. Throws Error where it is there and not empty.
/// A folder that files are added to: one that is there, or a new one.
void will_fill(const std::string& option, const std::filesystem::path& folder);
void will_create(const std::string& option, const std::filesystem::path& folder);

/// A calibration or a recording is the work of hours: it is not replaced by accident. Throws Error where the file of the option exists, unless files
/// are replaced.
void expect_free(const std::string& option, const std::filesystem::path& file);
void replace_files();  ///< from now on, as --force says

/// read_session; the verb reads all files that the session names.
Session session_at(const std::filesystem::path& path);
/// The verb reads all files that this session names.
void will_read_files_of(const Session& session);

/// Before another verb in the same process.
void forget_files();

}  // namespace imulab::command
