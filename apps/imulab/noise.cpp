// imulab noise RECORDING|SESSION
#include "imulab/results/noise.hpp"

#include "apps/imulab/command.hpp"
#include "apps/imulab/files.hpp"
#include "apps/imulab/inspected.hpp"
#include "apps/imulab/report.hpp"
#include "apps/imulab/session_recording.hpp"
#include "imulab/core/error.hpp"
#include "imulab/formats/recording/reader.hpp"
#include "imulab/formats/recording/stored.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/terminal.hpp"
#include "imulab/report/noise_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace imulab::command {

namespace {

struct Options {
  std::vector<std::string> recordings, declarations;
  std::string one, output, report, deviation = "overlapping-allan";
  double in_memory_mb = 336;  // six million rows of seven numbers: the analysis then takes about a gigabyte
  bool json = false, force = false, remove_temperature = false;
};

struct Log {
  NoiseAnalysis analysis;
  std::string page;  // where one is asked for
};

Log analyzed(const Options& o, const RecordingView& recording, const StillRange& still) {
  const Progress progress("analyzing");
  Log log{analyze_noise(recording, still, {*deviation_kind(o.deviation), o.remove_temperature}), {}};
  if (!o.report.empty()) log.page = noise_page(log.analysis, recording, still.range);
  return log;
}

/// Numbers of a log without a session that are inspected: of a longer log's the first third of so many. What a log at rest holds shows early, and to
/// inspect three hours takes as long as to analyze them.
constexpr std::uint64_t most_inspected = 14'000'000;

std::uint64_t most_bytes(const Options& o) { return static_cast<std::uint64_t>(1e6 * o.in_memory_mb); }

Log read_log(const Options& o, const Session& session) {
  const RecordingSource& source = named_recording(session, o.one);
  std::string why_not;
  const auto reading_shown = [](const auto& read) {
    const Progress progress("reading");
    return read();
  };
  if (std::optional<StoredReading> stored = reading_shown([&] { return read_stored(session, source, most_bytes(o), why_not); })) {
    for (const std::string& text : stored->warnings) warn(text);
    const std::size_t filled = stored->recording.fill_short_gaps();
    const RecordingView recording = stored->recording.view();
    return analyzed(o, recording, still_range(recording, session, filled));
  }
  if (!why_not.empty()) warn(why_not);
  RecordingReading reading = reading_shown([&] { return read_recording(session, source); });
  for (const std::string& text : reading.warnings) warn(text);
  const StillPart still = still_part(std::move(reading.recording), session);
  return analyzed(o, still.recording, still);
}

/// Axes without noise are an answer that the log does not give.
void expect_noise(const NoiseAnalysis& analysis) {
  std::string silent;
  for (const NoiseAxis& axis : analysis.axes)
    if (!axis.fit) silent += (silent.empty() ? "" : ", ") + axis.name;
  if (!silent.empty()) throw Unsupported(fmt::format("{}: no noise to be seen on {}; expected readings that vary", analysis.recording, silent));
}

template <class Result>
void write_result(const Options& o, const Result& result) {
  const bool printed = o.output == "-";
  if (o.json || !printed) o.json ? print_json(noise_json(result)) : print(noise_text(result));
  if (o.output.empty() || (o.json && printed)) return;
  write_whole(o.output, noise_json(result));
  if (!o.json && !printed) print(fmt::format("\nwritten: {}\n", o.output));
}

void run(const Options& o) {
  expect_free("-o", o.output, o.force);
  if (o.recordings.size() > 1 && !o.report.empty()) throw Error("--report: shows one log; expected one recording");
  std::vector<Session> sessions;  // all of them before the first is analyzed
  const std::uint64_t inspected = std::min<std::uint64_t>(most_bytes(o) / sizeof(double), most_inspected);
  for (const std::string& path : o.recordings) sessions.push_back(open_session(path, o.declarations, inspected));
  if (sessions.size() == 1) {
    const Log log = read_log(o, sessions[0]);
    for (const std::string& text : log.analysis.warnings) warn(text);
    write_result(o, log.analysis);
    if (!o.report.empty()) write_whole(o.report, log.page);
    return expect_noise(log.analysis);
  }
  std::vector<NoiseAnalysis> logs;
  for (std::size_t i = 0; i < sessions.size(); ++i) {
    const std::string& path = o.recordings[i];
    logs.push_back(read_log(o, sessions[i]).analysis);
    logs.back().recording = path;
    for (const std::string& text : logs.back().warnings) warn(path + ": " + text);
  }
  const NoiseBatch batch = noise_batch(std::move(logs));
  write_result(o, batch);
  for (const NoiseAnalysis& log : batch.logs) expect_noise(log);
}

}  // namespace

void add_noise(Verb app) {
  const auto o = std::make_shared<Options>();
  Verb verb = app.verb("noise", "Allan deviation and noise coefficients of a log at rest, with confidence");
  verb.option("RECORDING", o->recordings,
              "a log at rest, or a session with one, - for either on standard input; several: mean, spread and worst of them")
      .required()
      .reads();
  verb.option("--recording FILE", o->one, "which of a session's recordings, where it has several");
  verb.option("--deviation KIND", o->deviation, "the deviation of the curve; the coefficients do not depend on it")
      .one_of({deviation_names.begin(), deviation_names.end()})
      .show_default();
  verb.flag("--remove-temperature", o->remove_temperature, "subtract a parabola of the temperature first");
  add_declarations(verb, o->declarations);
  verb.option("--in-memory MB", o->in_memory_mb,
              "columns that take more than this go through temporary files (in TMPDIR, else /var/tmp); the results do not depend on it")
      .in_range(1, 1e6)
      .show_default();
  verb.option("-o,--output FILE", o->output, "write the result as JSON, with the whole curve").writes();
  verb.flag("--force", o->force, "replace the file if there is one");
  verb.flag("--json", o->json, "print the result as JSON");
  verb.example("imulab noise night.csv -o noise.json");
  add_report_option(verb, o->report);
  verb.example("imulab noise unit1.csv unit2.csv unit3.csv");
  verb.example("zcat night.csv.gz | imulab noise -");
  verb.example("imulab noise night.csv --set gyro.unit=deg/s");
  verb.does([o] { run(*o); });
}

}  // namespace imulab::command
