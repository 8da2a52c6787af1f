// imulab noise RECORDING|SESSION
#include "imulab/tasks/noise.hpp"

#include "apps/imulab/command.hpp"
#include "apps/imulab/files.hpp"
#include "apps/imulab/sessions.hpp"
#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/noise/data_sheet.hpp"
#include "imulab/formats/text/terminal.hpp"
#include "imulab/results/noise_requirement.hpp"
#include "imulab/tasks/inspect.hpp"

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace imulab::command {

namespace {

/// Numbers of a log without a session that are inspected: of a longer log's the first third of so many. The content of a log at rest shows early, and
/// to inspect three hours takes as long as to analyze them.
constexpr std::uint64_t most_inspected = 14'000'000;

AnswerOf<NoiseAnalysis> analyzed(const Session& session, const NoiseVerbOptions& o) {
  const RecordingSource& source = named_recording(session, o.recording);
  const Progress progress("analyzing");
  return noise_answer(session, source, o, warn);
}

void write_and_show(const Answer& answer, const NoiseVerbOptions& o) {
  if (!o.output.empty()) write_whole(o.output, answer.document());
  show(answer, o, o.output.empty() ? "" : "\n" + written_text(o.output) + "\n");
}

Answer without_log(const NoiseVerbOptions& o) {
  if (!o.datasheet) throw Error("RECORDING is required; usage: imulab noise RECORDING..., or imulab noise --datasheet SHEET");
  return data_sheet_answer(o);
}

void run(const NoiseVerbOptions& o) {
  if (o.require) errors_of_option("require", [&] { expect_noise_limits(*o.require); });
  if (o.recordings.empty()) return write_and_show(without_log(o), o);
  if (o.datasheet) {
    if (o.recordings.size() > 1) throw Error("--datasheet: compares one log; expected one RECORDING");
    errors_of_option("datasheet", [&] { read_data_sheet(*o.datasheet); });
  }
  std::vector<Session> sessions;  // all of them before the first is analyzed
  const std::uint64_t inspected = std::min<std::uint64_t>(o.most_bytes() / sizeof(double), most_inspected);
  const std::vector<std::string> recordings = recordings_named(o.recordings);
  for (const std::string& path : recordings) sessions.push_back(open_session(path, {o.declarations, o.topics}, inspected, Purpose::noise));
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
