#include "apps/imulab/sessions.hpp"

#include "apps/imulab/command.hpp"
#include "apps/imulab/files.hpp"
#include "imulab/core/error.hpp"
#include "imulab/formats/calibration/file.hpp"
#include "imulab/formats/recording/reader.hpp"
#include "imulab/formats/session/file.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/terminal.hpp"
#include "imulab/tasks/inspect.hpp"
#include "imulab/tasks/usable.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <string_view>
#include <utility>

namespace imulab::command {
namespace {

/// True where a text is a session and no recording: a line of its first 64 KiB begins with format = "imulab.session/, which no row of numbers does.
bool is_session_text(std::string_view text) {
  text = text.substr(0, std::size_t{1} << 16);
  if (text.find('\0') != std::string_view::npos) return false;
  const auto takes = [](std::string_view& line, std::string_view word) {
    line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
    if (!line.starts_with(word)) return false;
    line.remove_prefix(word.size());
    return true;
  };
  for (std::size_t begin = 0, end = 0; end != std::string_view::npos; begin = end + 1) {
    end = text.find('\n', begin);
    std::string_view line = text.substr(begin, end - begin);
    if (takes(line, "format") && takes(line, "=") && (takes(line, "\"imulab.session/") || takes(line, "'imulab.session/"))) return true;
  }
  return false;
}

/// A session says so in its first lines; a folder has one.
bool is_session(const std::filesystem::path& path) {
  if (std::filesystem::is_directory(path) || path.extension() == ".toml" || !std::filesystem::is_regular_file(path)) return true;
  return is_session_text(MappedFile(path).text());
}

Session inspected(const std::filesystem::path& path, const std::vector<std::string>& texts, std::size_t most_numbers) {
  const InspectionTask task{.files = {path.string()}, .declared = parse_declarations(texts), .most_numbers = most_numbers};
  const auto [inspection, session] = [&] {
    const Progress progress("inspecting");
    Inspection found = inspect_files(task);
    Session inspected_session = session_for(found, task, "declare with --set KEY=VALUE, or write a session");
    return std::pair(std::move(found), std::move(inspected_session));
  }();
  for (const std::string& line : inspection.evidence) note("assumed: " + line);
  if (const std::string gravity = assumed_gravity(session); !gravity.empty())
    note(fmt::format("assumed: {}; declare the place: --set latitude_deg=47.4", gravity));
  return session;
}

void expect_no_declarations(const std::vector<std::string>& texts) {
  if (!texts.empty()) throw Error("--set: declares a recording; expected it without a session, which declares all itself");
}

/// A session, or rows, which are kept to be read again.
Session session_of_standard_input(const std::vector<std::string>& texts, std::size_t most_numbers) {
  constexpr double longest_wait_s = 1e9;  // to its end
  const std::string name = input_name("-");
  std::string text = [] {
    const Progress progress("reading standard input");
    return read_stream("-", longest_wait_s).text;
  }();
  if (text.empty()) throw Error(name + ": is empty; expected a session, or rows of a recording");
  if (!is_session_text(text)) {
    keep_as_file(name, std::move(text));
    return inspected(name, texts, most_numbers);
  }
  expect_no_declarations(texts);
  if (text.size() > longest_settings) throw Error(fmt::format("{}: a session of more than {} MiB; expected less", name, longest_settings >> 20));
  Session session = parse_session(text, name);
  will_read_files_of(session);
  return session;
}

}  // namespace

Session open_session(const std::filesystem::path& path, const std::vector<std::string>& texts, std::size_t most_numbers) {
  if (path == "-") return session_of_standard_input(texts, most_numbers);
  if (!is_session(path)) return inspected(path, texts, most_numbers);
  if (std::filesystem::exists(path)) expect_no_declarations(texts);
  return session_at(path);
}

Session open_sessions(const std::vector<std::string>& paths, const std::vector<std::string>& texts) {
  Session all = open_session(paths.front(), texts);
  if (paths.size() == 1) return all;
  const auto folder_of = [](const Session& session) { return std::filesystem::absolute(session.file).parent_path(); };
  for (std::size_t k = 1; k < paths.size(); ++k) {
    Session more = open_session(paths[k], texts);
    more.imu.name = all.imu.name;  // of a recording that was inspected, its file's
    const char* const other = !(more.imu == all.imu) ? "[imu]" : !(more.site == all.site) ? "[site]" : !(more.rigs == all.rigs) ? "[rig]" : nullptr;
    if (other)
      throw Error(
          fmt::format("{}: its {} is not that of {}; expected recordings of one unit, at one place, with one rig", paths[k], other, paths[0]));
    for (RecordingSource& recording : more.recordings) {
      const std::string name = (folder_of(more) / recording.file).lexically_normal().lexically_relative(folder_of(all).lexically_normal()).string();
      for (Step& step : more.steps)
        if (step.recording == recording.file) step.recording = name;
      recording.file = name;
      const auto named = [&](const RecordingSource& r) { return std::filesystem::path(r.file).lexically_normal() == name; };
      if (std::any_of(all.recordings.begin(), all.recordings.end(), named)) throw Error(fmt::format("{}: {} was given before", paths[k], name));
      all.recordings.push_back(std::move(recording));
    }
    all.steps.insert(all.steps.end(), std::make_move_iterator(more.steps.begin()), std::make_move_iterator(more.steps.end()));
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
  return std::move(reading.recording);
}

Calibration read_usable(const std::string& file, bool allow_undetermined) {
  Calibration calibration = read_calibration(file);
  expect_usable(calibration, file, allow_undetermined, warn);
  return calibration;
}

}  // namespace imulab::command
