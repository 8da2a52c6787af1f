#include "imulab/tasks/verify.hpp"

#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/text/json.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace imulab {
namespace {

const char* state_name(FileState state) { return state == FileState::unchanged ? "unchanged" : state == FileState::changed ? "changed" : "missing"; }

using Files = std::vector<VerifiedFile>;

std::string files_in_state(const Files& files, FileState state) {
  std::string list;
  for (const VerifiedFile& f : files)
    if (f.state == state) list += (list.empty() ? "" : ", ") + f.file.string();
  return list;
}

std::string shortcomings(const std::string& calibration, const Files& files) {
  const std::string changed = files_in_state(files, FileState::changed), missing = files_in_state(files, FileState::missing);
  if (!changed.empty()) return fmt::format("{}: not what it was made from: {}", calibration, changed);
  if (!missing.empty())
    return fmt::format("{}: not found: {}; expected them there, or --session-at with the new place of their session", calibration, missing);
  return "";
}

/// Files that are unchanged make a doubtful calibration no better.
Conclusion conclusion_of(const Files& files, const Quality& quality) {
  const auto unchanged = std::count_if(files.begin(), files.end(), [](const VerifiedFile& f) { return f.state == FileState::unchanged; });
  Conclusion out{unchanged == std::ssize(files) ? Verdict::good : Verdict::doubtful,
                 fmt::format("{} of {} files are unchanged", unchanged, files.size())};
  if (quality.verdict == Verdict::doubtful)
    out.verdict = quality.verdict,
    out.headline += fmt::format("; the calibration itself is doubtful: {}", fmt::join(quality.findings.reasons(), "; "));
  return out;
}

std::string json_of(const Files& verified) {
  std::vector<JsonFields> files;
  for (const VerifiedFile& f : verified) files.push_back({{{"file", f.file.string()}, {"state", std::string(state_name(f.state))}}});
  const bool unchanged = std::all_of(verified.begin(), verified.end(), [](const VerifiedFile& f) { return f.state == FileState::unchanged; });
  return fields_json({{{"files", files}, {"unchanged", unchanged}}});
}

std::string text_of(const Files& files) {
  std::string text;
  for (const VerifiedFile& f : files) text += fmt::format("{}: {}\n", f.file.string(), state_name(f.state));
  return text;
}

}  // namespace

Verb& declare(Verb& command, VerifyOptions& o) {
  Verb& verb = command.verb("verify", "Check that the recordings and the session of a calibration are still the same files");
  verb.option("CALIBRATION", o.calibration, "calibration.json").required().reads();
  verb.option("--session-at PLACE", o.session_at, "the session's folder or file, if it has moved");
  json_option(verb, o.json);
  verb.example("imulab verify calibration.json");
  return verb;
}

std::filesystem::path find_session(const std::string& given, const std::string& calibration_file, const std::string& recorded) {
  namespace fs = std::filesystem;
  if (!given.empty()) return fs::is_directory(given) ? fs::path(given) / "session.toml" : fs::path(given);
  const fs::path folder = fs::path(calibration_file).parent_path();
  for (const fs::path& place : {fs::path(recorded), folder / recorded, folder / fs::path(recorded).filename()})
    if (fs::is_regular_file(place)) return place;
  return recorded;
}

AnswerOf<Files> verify(const VerifyOptions& o) {
  const Calibration calibration = read_calibration(o.calibration);
  if (calibration.sources.empty())
    throw Error(fmt::format("{}: has no hashes of recordings; expected a calibration that imulab made from files", o.calibration));
  const auto files = std::make_shared<const Files>(verify_sources(calibration, find_session(o.session_at, o.calibration, calibration.session_file)));
  return {{.json = [files] { return json_of(*files); },
           .table = [files](bool) { return text_of(*files); },
           .shortcomings = shortcomings(o.calibration, *files),
           .conclusion = conclusion_of(*files, calibration.quality)},
          files};
}

}  // namespace imulab
