// For tests of the command as a user types it.
#pragma once

#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdlib.h>
#include <string>
#include <sys/wait.h>

namespace imulab::test {

/// A folder of its own for one test, removed at its end.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "imulab-test-XXXXXX").string();
    path_ = ::mkdtemp(name.data());
  }
  ~TemporaryFolder() { std::filesystem::remove_all(path_); }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

  std::filesystem::path write(const std::string& file, const std::string& text) const {
    std::filesystem::create_directories((path_ / file).parent_path());
    std::ofstream(path_ / file, std::ios::binary) << text;
    return path_ / file;
  }
  std::string read(const std::filesystem::path& file) const {
    std::ostringstream text;
    text << std::ifstream(path_ / file, std::ios::binary).rdbuf();
    return text.str();
  }

 private:
  std::filesystem::path path_;
};

struct CommandResult {
  int exit_code = -1;
  std::string output, errors;
};

/// Runs a shell command in `folder`.
inline CommandResult run_shell(const TemporaryFolder& folder, const std::string& command) {
  const int status = std::system(("cd '" + folder.path().string() + "' && (" + command + ") >.standard-output 2>.standard-error </dev/null").c_str());
  CommandResult result{WIFEXITED(status) ? WEXITSTATUS(status) : -1, folder.read(".standard-output"), folder.read(".standard-error")};
  std::filesystem::remove(folder.path() / ".standard-output");
  std::filesystem::remove(folder.path() / ".standard-error");
  return result;
}

/// Runs `imulab ARGUMENTS` in `folder`.
inline CommandResult run_imulab(const TemporaryFolder& folder, const std::string& arguments) {
  return run_shell(folder, std::string("'") + IMULAB_COMMAND + "' " + arguments);
}

}  // namespace imulab::test
