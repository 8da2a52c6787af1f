// For tests of the command as a user types it.
#pragma once

#include "tests/temporary_folder.hpp"
#include "tests/tested_build.hpp"
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <sys/wait.h>

namespace imulab {

inline std::string read_text(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

struct CommandResult {
  int exit_code = -1;
  std::string output, errors;
};

/// Runs a shell command in `folder`.
inline CommandResult run_shell(const TemporaryFolder& folder, const std::string& command) {
  const auto output = folder / ".standard-output", errors = folder / ".standard-error";
  const int status =
      std::system(("cd '" + folder.path().string() + "' && (" + command + "\n) >.standard-output 2>.standard-error </dev/null").c_str());
  CommandResult result{WIFEXITED(status) ? WEXITSTATUS(status) : -1, read_text(output), read_text(errors)};
  std::filesystem::remove(output);
  std::filesystem::remove(errors);
  return result;
}

/// Sentences of a terminal's lines as one: each run of spaces and line ends is one space.
inline std::string on_one_line(const std::string& text) {
  std::istringstream words(text);
  std::string line;
  for (std::string word; words >> word;) line += (line.empty() ? "" : " ") + word;
  return line;
}

/// Runs `imulab ARGUMENTS` in `folder`.
inline CommandResult run_imulab(const TemporaryFolder& folder, const std::string& arguments) {
  return run_shell(folder, "'" + command_path() + "' " + arguments);
}

}  // namespace imulab
