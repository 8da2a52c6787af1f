// Recordings in place of sessions: they are inspected first.
#pragma once

#include "apps/imulab/command.hpp"
#include "imulab/inspection/inspection.hpp"
#include "imulab/io/recording/signals.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace imulab::command {

/// The option --set KEY=VALUE.
void add_declarations(Verb& verb, std::vector<std::string>& declarations);
/// Throws Error for what is not KEY=VALUE.
Declarations parse_declarations(const std::vector<std::string>& texts);

/// Reads and inspects files of one recording. Throws Error as read_signals and inspect do. `topics`: several of one file, or none. `longest_s`:
/// for how long a stream is read. `most_numbers`: of a file that can be read in pieces no more are looked at.
Inspection inspect_files(const std::vector<std::string>& files, const std::vector<std::string>& topics, const Declarations& declared,
                         double longest_s = stream_s, std::size_t most_numbers = static_cast<std::size_t>(-1));

/// The session of that name; a recording is inspected, and what is assumed goes to standard error. Throws Unsupported, with what has to be declared,
/// where the data leave something open. `most_numbers`: as inspect_files.
Session open_session(const std::filesystem::path& path, const std::vector<std::string>& declarations,
                     std::size_t most_numbers = static_cast<std::size_t>(-1));

}  // namespace imulab::command
