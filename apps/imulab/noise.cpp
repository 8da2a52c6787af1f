// imulab noise RECORDING|SESSION
#include "imulab/tasks/noise.hpp"

#include "apps/imulab/command.hpp"
#include "apps/imulab/files.hpp"
#include "apps/imulab/sessions.hpp"
#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/noise/data_sheet.hpp"
#include "imulab/formats/recording/reader.hpp"
#include "imulab/formats/text/terminal.hpp"
#include "imulab/results/noise_requirement.hpp"
#include "imulab/results/summary.hpp"
#include "imulab/tasks/inspect.hpp"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace imulab::command {

namespace {

/// Numbers of a log without a session that are inspected: of a longer log's the first third of so many. The content of a log at rest shows early, and
/// to inspect three hours takes as long as to analyze them.
constexpr std::uint64_t most_inspected = 14'000'000;

AnswerOf<NoiseAnalysis> analyzed(const Session& session, const NoiseVerbOptions& o) {
  const RecordingSource& source = named_recording(session, o.recording);
  const Progress progress("analyzing");
  try {
    return noise_answer(session, source, o, warn);
  } catch (const Unsupported& e) {
    if (o.moving.empty()) throw;
    throw Unsupported(std::string(e.what()) + "; before --moving, expected the log at rest");
  }
}

void write_and_show(const Answer& answer, const NoiseVerbOptions& o) {
  if (!o.output.empty()) write_whole(o.output, answer.document());
  show(answer, o, o.output.empty() ? "" : "\n" + written_text(o.output) + "\n");
}

/// Declarations are of the files that are no sessions, if there is one.
RecordingWords words_for(const std::string& path, const NoiseVerbOptions& o) {
  bool any = false;
  for (const auto* const paths : {&o.recordings, &o.moving})
    for (const std::string& other : *paths) any = any || (!other.ends_with(".json") && !declares_itself(other));
  return any && declares_itself(path) ? RecordingWords{} : RecordingWords{o.declarations, o.topics};
}

/// A log with vibration or motion, in memory, or a result.
MovingInput given_after_moving(const std::string& path, const NoiseVerbOptions& o) {
  if (path.ends_with(".json")) return moving_input(path);
  const Session session = open_session(path, words_for(path, o), numbers_inspected, Purpose::noise);
  RecordingReading reading = read_recording(session, named_recording(session, ""));
  for (const std::string& text : reading.warnings) warn(path + ": " + text);
  reading.recording.name = path;
  return std::make_shared<const Recording>(std::move(reading.recording));
}

/// The noise at rest of a file that this command wrote, or nothing.
std::optional<NoiseAnalysis> saved_noise(const std::string& path) {
  if (!path.ends_with(".json")) return std::nullopt;
  SavedResult result = read_answer(path).result;
  if (NoiseAnalysis* const noise = std::get_if<NoiseAnalysis>(&result)) return std::move(*noise);
  throw Error(path + ": is not the noise of one log; expected noise.json of imulab noise, or a log at rest");
}

Answer without_log(const NoiseVerbOptions& o) {
  if (!o.datasheet) throw Error("RECORDING is required; usage: imulab noise RECORDING..., or imulab noise --datasheet SHEET");
  return data_sheet_answer(o);
}

void run(const NoiseVerbOptions& given) {
  NoiseVerbOptions o = given;
  if (o.require) errors_of_option("require", [&] { expect_noise_limits(*o.require); });
  if (!o.moving.empty() && o.recordings.size() > 1) throw Error("--moving: is compared with one log at rest; expected one RECORDING before it");
  for (const std::string& path : o.moving) o.moving_inputs.push_back(given_after_moving(path, o));
  if (o.recordings.empty()) return write_and_show(without_log(o), o);
  if (!o.moving.empty())
    if (std::optional<NoiseAnalysis> saved = saved_noise(o.recordings[0])) return write_and_show(noise_answer(std::move(*saved), o), o);
  if (o.datasheet) {
    if (o.recordings.size() > 1) throw Error("--datasheet: compares one log; expected one RECORDING");
    errors_of_option("datasheet", [&] { read_data_sheet(*o.datasheet); });
  }
  std::vector<Session> sessions;  // all of them before the first is analyzed
  const std::uint64_t inspected = std::min<std::uint64_t>(o.most_bytes() / sizeof(double), most_inspected);
  const std::vector<std::string> recordings = recordings_named(o.recordings);
  for (const std::string& path : recordings) sessions.push_back(open_session(path, words_for(path, o), inspected, Purpose::noise));
  if (sessions.size() == 1) return write_and_show(analyzed(sessions[0], o), o);
  std::vector<NoiseAnalysis> logs;
  NoiseVerbOptions one = o;
  one.report.clear();  // the page is that of all
  for (std::size_t i = 0; i < sessions.size(); ++i) {
    logs.push_back(*analyzed(sessions[i], one).data);
    logs.back().recording = recordings[i];
    for (const std::string& text : logs.back().warnings) warn(recordings[i] + ": " + text);
  }
  write_and_show(noise_answer(std::move(logs), o), o);
}

}  // namespace

void add_noise(Verb& app) { add<NoiseVerbOptions>(app, run); }

}  // namespace imulab::command
