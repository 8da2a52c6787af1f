#include "imulab/tasks/verify.hpp"

#include "imulab/core/error.hpp"
#include "imulab/formats/text/json.hpp"

#include <fmt/core.h>

#include <algorithm>

namespace imulab {
namespace {

const char* state_name(FileState state) { return state == FileState::unchanged ? "unchanged" : state == FileState::changed ? "changed" : "missing"; }

std::string files_in_state(const VerifiedCalibration& verified, FileState state) {
  std::string list;
  for (const VerifiedFile& f : verified.files)
    if (f.state == state) list += (list.empty() ? "" : ", ") + f.file.string();
  return list;
}

}  // namespace

std::filesystem::path find_session(const std::string& given, const std::string& calibration_file, const std::string& recorded) {
  namespace fs = std::filesystem;
  if (!given.empty()) return fs::is_directory(given) ? fs::path(given) / "session.toml" : fs::path(given);
  const fs::path folder = fs::path(calibration_file).parent_path();
  for (const fs::path& place : {fs::path(recorded), folder / recorded, folder / fs::path(recorded).filename()})
    if (fs::is_regular_file(place)) return place;
  return recorded;
}

VerifiedCalibration verify(const std::string& calibration_file, const std::string& session) {
  const Calibration calibration = read_calibration(calibration_file);
  if (calibration.sources.empty())
    throw Error(fmt::format("{}: has no hashes of recordings; expected a calibration that imulab made from files", calibration_file));
  return {calibration_file, verify_sources(calibration, find_session(session, calibration_file, calibration.session_file))};
}

std::string verification_json(const VerifiedCalibration& verified) {
  std::vector<JsonFields> files;
  for (const VerifiedFile& f : verified.files) files.push_back({{{"file", f.file.string()}, {"state", std::string(state_name(f.state))}}});
  return fields_json({{{"files", files}, {"unchanged", shortcomings(verified).empty()}}});
}

std::string verification_text(const VerifiedCalibration& verified) {
  std::string text;
  for (const VerifiedFile& f : verified.files) text += fmt::format("{}: {}\n", f.file.string(), state_name(f.state));
  return text;
}

std::string shortcomings(const VerifiedCalibration& verified) {
  const std::string changed = files_in_state(verified, FileState::changed), missing = files_in_state(verified, FileState::missing);
  if (!changed.empty()) return fmt::format("{}: not what it was made from: {}", verified.name, changed);
  if (!missing.empty()) return fmt::format("{}: not found: {}; expected them there, or their session's new place", verified.name, missing);
  return "";
}

}  // namespace imulab
