#include "apps/imulab/sessions.hpp"

#include "apps/imulab/command.hpp"
#include "apps/imulab/files.hpp"
#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/finding_code.hpp"
#include "imulab/formats/recording/reader.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/several_files.hpp"
#include "imulab/formats/text/terminal.hpp"
#include "imulab/rig/rig_errors.hpp"
#include "imulab/tasks/given_files.hpp"
#include "imulab/tasks/inspect.hpp"
#include "imulab/tasks/usable.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <initializer_list>
#include <iterator>
#include <string_view>
#include <utility>

namespace imulab::command {
namespace {

/// A session says so in its first lines; a folder has one, or is a recording.
bool is_session(const std::filesystem::path& path) {
  if (is_several_files(path)) return std::filesystem::exists(path / "session.toml");
  if (path.extension() == ".toml" || !std::filesystem::is_regular_file(path)) return true;
  return is_session_text(MappedFile(path).text());
}

bool evidence_is_shown = false;
std::string last_summary;  // several recordings of a unit are mostly alike

/// Leaves out what only a calibration needs.
void keep_for_noise(Inspection& found) {
  std::erase_if(found.findings, [](const Finding& f) {
    return f.code == Code::axes_found || f.code == Code::up_at_first_rest || f.code == Code::rests_found || f.code == Code::turns_explained ||
           f.subject == "gyro.axes" || f.subject == "accel.axes";
  });
  for (Finding& f : found.findings)
    if (f.subject == "gyro.unit") f.text = "gyro.unit: a log at rest does not show it; declare --set gyro.unit=deg/s, rad/s or another, or count";
}

std::string triad_text(const Inspection& found, std::string_view name, const TriadSource& triad) {
  std::string columns;
  for (const ColumnFinding& column : found.columns)
    if (column.role.starts_with(name)) columns += (columns.empty() ? "" : ", ") + column.name;
  return fmt::format("{} {} in {}", name, columns, triad.unit);
}

/// "assumed: 100 Hz; gyro gx, gy, gz in rad/s, ...": what was found, in a line.
std::string summary_of(const Inspection& found, const std::vector<std::string>& guesses) {
  std::vector<std::string> parts;
  if (found.rate_hz) parts.push_back(fmt::format("{:.5g} Hz", *found.rate_hz));
  if (!found.source.gyro.columns.empty()) parts.push_back(triad_text(found, "gyro", found.source.gyro));
  if (!found.source.accel.columns.empty()) parts.push_back(triad_text(found, "accel", found.source.accel));
  parts.insert(parts.end(), guesses.begin(), guesses.end());
  return fmt::format("assumed: {} (--verbose: why)", fmt::join(parts, "; "));
}

/// What no recording shows and a calibration depends on.
std::vector<std::string> guesses_of(const Session& session) {
  std::vector<std::string> out;
  if (std::string gravity = assumed_gravity(session); !gravity.empty()) out.push_back(gravity + "; declare the place: --set latitude_deg=47.4");
  if (!session.imu.grade) out.emplace_back("no grade, so effects and nonlinear terms as large as the data say; declare it: --set grade=mems");
  return out;
}

void tell_assumptions(const Inspection& found, const Session& session, Purpose purpose) {
  std::vector<std::string> guesses = purpose == Purpose::calibration ? guesses_of(session) : std::vector<std::string>{};
  if (evidence_is_shown) {
    for (const std::string& line : found.evidence()) note("assumed: " + line);
    for (const std::string& guess : guesses) note("assumed: " + guess);
    return;
  }
  const auto up = std::ranges::find(found.findings, Code::up_at_first_rest, &Finding::code);
  if (purpose == Purpose::calibration && up != found.findings.end()) guesses.push_back(up->text);
  if (std::string summary = summary_of(found, guesses); summary != last_summary) note(last_summary = std::move(summary));
}

Session inspected(const std::filesystem::path& path, const RecordingWords& words, std::size_t most_numbers, Purpose purpose) {
  const InspectionTask task{
      .files = {path.string()}, .topics = words.topics, .declared = parse_declarations(words.declarations), .most_numbers = most_numbers};
  const auto [inspection, session] = [&] {
    const Progress progress("inspecting");
    Inspection found = inspect_files(task);
    if (purpose == Purpose::noise) keep_for_noise(found);
    Session inspected_session = session_for(found, task, "declare with --set KEY=VALUE, or write a session");
    return std::pair(std::move(found), std::move(inspected_session));
  }();
  tell_assumptions(inspection, session, purpose);
  return session;
}

void expect_no_declarations(const RecordingWords& words) {
  if (!words.declarations.empty()) throw Error("--set: declares a recording; expected it without a session, which declares all itself");
  if (!words.topics.empty()) throw Error("--topic: chooses a table of a recording; expected it without a session, which names it by topic");
}

/// A session that declares all itself, as inspection writes them, too.
Session declared(Session session, Purpose purpose) {
  if (const std::string gravity = assumed_gravity(session); !gravity.empty() && purpose == Purpose::calibration)
    note(fmt::format("{}: assumed: {}; declare the place: latitude_deg in [site]", session.file, gravity));
  return session;
}

/// A session, or rows, which are kept to be read again.
Session session_of_standard_input(const RecordingWords& words, std::size_t most_numbers, Purpose purpose) {
  constexpr double longest_wait_s = 1e9;  // to its end
  const std::string name = input_name("-");
  std::string text = [] {
    const Progress progress("reading standard input");
    return read_stream("-", longest_wait_s).text;
  }();
  if (text.empty()) throw Error(name + ": is empty; expected a session, or rows of a recording");
  if (!is_session_text(text)) {
    keep_as_file(name, std::move(text));
    return inspected(name, words, most_numbers, purpose);
  }
  expect_no_declarations(words);
  if (text.size() > longest_settings) throw Error(fmt::format("{}: a session of more than {} MiB; expected less", name, longest_settings >> 20));
  Session session = parse_session(text, name);
  will_read_files_of(session);
  return declared(std::move(session), purpose);
}

}  // namespace

void show_evidence(bool shown) { evidence_is_shown = shown, last_summary.clear(); }

bool declares_itself(const std::string& path) { return path != "-" && is_session(without_slash(path)); }

Session open_session(const std::filesystem::path& named, const RecordingWords& words, std::size_t most_numbers, Purpose purpose) {
  const std::filesystem::path path = without_slash(named);
  if (path == "-") return session_of_standard_input(words, most_numbers, purpose);
  if (!is_session(path)) return inspected(path, words, most_numbers, purpose);
  if (std::filesystem::exists(path)) expect_no_declarations(words);
  return declared(session_at(path), purpose);
}

namespace {

namespace fs = std::filesystem;

fs::path folder_of(const Session& session) { return fs::absolute(session.file).parent_path().lexically_normal(); }

/// Each aid goes with its session's only recording.
void assign_aids(Session& session) {
  if (session.recordings.size() != 1) return;
  for (Aid& aid : session.aids) aid.recording = session.recordings.front().file;
}

/// A file of one session as another names it; a topic stays.
std::string moved_name(const std::string& file, const Session& from, const Session& to) {
  std::error_code none;
  if (const fs::path path = folder_of(from) / file; fs::exists(path, none) || fs::exists(folder_of(from) / file.substr(0, file.find(':')), none))
    return path.lexically_normal().lexically_relative(folder_of(to)).string();
  return file;
}

/// What two sessions of one IMU have to share. Receivers tell the place of a drive.
void expect_same_unit(const Session& all, const Session& more, const std::string& path, const std::string& first) {
  const bool drives = !all.aids.empty() && !more.aids.empty();
  const bool same_place = drives ? more.site.given_gravity == all.site.given_gravity : more.site == all.site;
  const char* const other = !(more.imu == all.imu) ? "[imu]" : !same_place ? "[site]" : !(more.rigs == all.rigs) ? "[rig]" : nullptr;
  if (other) throw Error(fmt::format("{}: its {} is not that of {}; expected recordings of one IMU, at one place, with one rig", path, other, first));
}

}  // namespace

Session open_sessions(const std::vector<std::string>& paths, const RecordingWords& words) {
  Session all = open_session(paths.front(), words);
  if (paths.size() == 1) return all;
  assign_aids(all);
  for (std::size_t k = 1; k < paths.size(); ++k) {
    Session more = open_session(paths[k], words);
    more.imu.name = all.imu.name;  // of a recording that was inspected, its file's
    expect_same_unit(all, more, paths[k], paths[0]);
    assign_aids(more);
    for (RecordingSource& recording : more.recordings) {
      const std::string name = (folder_of(more) / recording.file).lexically_normal().lexically_relative(folder_of(all)).string();
      for (Step& step : more.steps)
        if (step.recording == recording.file) step.recording = name;
      for (Aid& aid : more.aids)
        if (aid.recording == recording.file) aid.recording = name;
      recording.file = name;
      const auto named = [&](const RecordingSource& r) { return fs::path(r.file).lexically_normal() == name; };
      if (std::any_of(all.recordings.begin(), all.recordings.end(), named)) throw Error(fmt::format("{}: {} was given before", paths[k], name));
      all.recordings.push_back(std::move(recording));
    }
    for (Aid& aid : more.aids)
      if (!aid.file.empty()) aid.file = moved_name(aid.file, more, all);
    all.steps.insert(all.steps.end(), std::make_move_iterator(more.steps.begin()), std::make_move_iterator(more.steps.end()));
    all.aids.insert(all.aids.end(), std::make_move_iterator(more.aids.begin()), std::make_move_iterator(more.aids.end()));
  }
  return all;
}

const RecordingSource& named_recording(const Session& session, const std::string& name) {
  if (session.recordings.empty()) return choose_recording(session, name);  // which no option would fix
  return errors_of_option("recording", [&]() -> const RecordingSource& { return choose_recording(session, name); });
}

Recording read_for(const Calibration& calibration, const Session& session, const RecordingSource& source) {
  check_thermal_units(calibration, source);
  RecordingReading reading = [&] {
    const Progress progress("reading");
    return read_recording(session, source);
  }();
  warn_each(reading.warnings);
  if (source.gyro.columns.empty() || source.accel.columns.empty())
    throw Error(
        fmt::format("{}: has no {}; expected a recording of both triads", source.file, source.gyro.columns.empty() ? "gyros" : "accelerometers"));
  return std::move(reading.recording);
}

UsableCalibration read_usable(const std::string& file, bool allow_undetermined, const std::string& allow) {
  Calibration calibration = read_calibration(file);
  std::vector<std::string> warnings = expect_usable(calibration, file, allow_undetermined, allow);
  warn_each(warnings);
  return {std::move(calibration), std::move(warnings)};
}

}  // namespace imulab::command
