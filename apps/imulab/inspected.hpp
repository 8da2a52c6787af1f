// Recordings in place of sessions: they are inspected first.
#pragma once

#include "apps/imulab/command.hpp"
#include "imulab/formats/recording/signals.hpp"
#include "imulab/inspection/inspection.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace imulab::command {

/// The option --set KEY=VALUE.
void add_declarations(Verb& verb, std::vector<std::string>& declarations);
/// Throws Error for what is not KEY=VALUE.
Declarations parse_declarations(const std::vector<std::string>& texts);

/// The session of that name; a recording is inspected, and what is assumed goes to standard error. Throws Unsupported, with what has to be declared,
/// where the data leave something open. `most_numbers`: as InspectionTask has it.
Session open_session(const std::filesystem::path& path, const std::vector<std::string>& declarations, std::size_t most_numbers = numbers_inspected);

}  // namespace imulab::command
