#include "apps/imulab/files.hpp"

#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/session/file.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/several_files.hpp"

#include <fmt/core.h>

#include <sys/stat.h>
#include <unistd.h>
#include <utility>
#include <vector>

namespace imulab::command {

namespace {

namespace fs = std::filesystem;

struct UsedFile {
  std::string identity, name, option;  // option: of an output
};
std::vector<UsedFile> inputs, outputs;
bool replaces = false;

/// Device and number of a file that is there, else its place behind all links. Empty for a device, a pipe or a folder, which nothing replaces.
std::string identity_of(const fs::path& file, int standard_stream) {
  struct stat status {};
  const bool standard = file == "-";
  if (standard ? ::fstat(standard_stream, &status) == 0 : ::stat(file.c_str(), &status) == 0) {
    if (S_ISREG(status.st_mode)) return fmt::format("{}:{}", status.st_dev, status.st_ino);
    return standard && standard_stream == STDOUT_FILENO ? "-" : "";
  }
  std::error_code none;
  return standard ? "" : fs::weakly_canonical(fs::absolute(behind_links(file)), none).string();
}

void expect_apart(const UsedFile& output, const UsedFile& other) {
  if (output.identity.empty() || output.identity != other.identity) return;
  const std::string what = other.option.empty() ? other.name : "the file of " + other.option;
  throw Error(fmt::format("{} {}: would overwrite {}; expected another file", output.option, output.name, what));
}

/// True for a truth that `simulate` or `trajectory` put beside a session: nothing gives it back.
bool is_truth(const fs::path& file) {
  std::error_code none;
  const fs::path place = fs::weakly_canonical(file, none);
  return (place.filename() == "truth.json" || place.filename() == "truth.csv") && fs::is_regular_file(place, none) &&
         fs::exists(place.parent_path() / "session.toml", none);
}

}  // namespace

void will_read(const fs::path& file) {
  std::error_code none;
  if (file.empty() || (file != "-" && !fs::exists(file, none) && !is_several_files(file))) return;  // whoever reads it says so
  if (fs::is_directory(file, none) && fs::exists(file / "session.toml", none)) return will_read(file / "session.toml");
  if (is_several_files(file)) {
    for (const fs::path& one : files_of(file)) will_read(one);
    return;
  }
  inputs.push_back({identity_of(file, STDIN_FILENO), file == "-" ? "the file of standard input" : file.string(), ""});
  for (const UsedFile& output : outputs) expect_apart(output, inputs.back());
}

void will_write(const std::string& option, const fs::path& file) {
  std::error_code none;
  if (file.empty()) return;
  const UsedFile output{identity_of(file, STDOUT_FILENO), file.string(), option};
  if (fs::is_directory(file, none)) throw Error(fmt::format("{} {}: is a folder; expected a file to write", option, output.name));
  if (is_truth(file)) throw Error(fmt::format("{} {}: would overwrite the truth of a session; expected another file", option, output.name));
  for (const UsedFile& input : inputs) expect_apart(output, input);
  for (const UsedFile& other : outputs) expect_apart(output, other);
  outputs.push_back(output);
}

void will_create(const std::string& option, const fs::path& folder) {
  std::error_code none;
  if (fs::exists(folder, none) && !(fs::is_directory(folder, none) && fs::is_empty(folder, none)))
    throw Error(fmt::format("{} {}: exists; expected a new or an empty folder", option, folder.string()));
}

void will_fill(const std::string& option, const fs::path& folder) {
  std::error_code none;
  if (fs::exists(folder, none) && !fs::is_directory(folder, none))
    throw Error(fmt::format("{} {}: is a file; expected a folder for the parts", option, folder.string()));
}

void replace_files() { replaces = true; }

void expect_free(const std::string& option, const fs::path& file) {
  std::error_code none;
  if (file.empty() || file == "-" || replaces || !fs::is_regular_file(file, none)) return;
  throw Error(fmt::format("{} {}: exists; expected a new file, or --force to replace it", option, file.string()));
}

void will_read_files_of(const Session& session) {
  will_read(session.file);
  for (const RecordingSource& recording : session.recordings)
    for (const std::string& file : recording.files()) will_read(session_path(session, file));
  for (const auto& file : {session.truth_file, session.imu.truth, session.noise_taken})
    if (file) will_read(session_path(session, *file));
  std::error_code none;
  for (const Aid& aid : session.aids)  // which may name a topic in place of a file
    if (const fs::path file = session_path(session, aid.file); !aid.file.empty() && fs::exists(file, none)) will_read(file);
}

Session session_at(const fs::path& path) {
  Session session = read_session(path);
  will_read_files_of(session);
  return session;
}

void forget_files() {
  inputs.clear(), outputs.clear(), replaces = false;
  forget_kept();
}

}  // namespace imulab::command
