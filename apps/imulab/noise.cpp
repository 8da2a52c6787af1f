// imulab noise RECORDING|SESSION
#include "imulab/io/result/noise.hpp"

#include "apps/imulab/command.hpp"
#include "apps/imulab/inspected.hpp"
#include "apps/imulab/session_recording.hpp"
#include "imulab/core/error.hpp"
#include "imulab/io/recording/file.hpp"
#include "imulab/io/text/file.hpp"

#include <fmt/format.h>

#include <memory>
#include <string>
#include <vector>

namespace imulab::command {

namespace {

struct Options {
  std::string recording, one, output, deviation = "overlapping-allan";
  std::vector<std::string> declarations;
  bool json = false, force = false;
};

constexpr DeviationKind kinds[] = {DeviationKind::overlapping_allan,    DeviationKind::allan, DeviationKind::modified_allan, DeviationKind::hadamard,
                                   DeviationKind::overlapping_hadamard, DeviationKind::total};

std::vector<std::string> kind_names() {
  std::vector<std::string> names;
  for (const DeviationKind kind : kinds) names.emplace_back(to_string(kind));
  return names;
}

DeviationKind kind_of(const std::string& name) {
  for (const DeviationKind kind : kinds)
    if (name == to_string(kind)) return kind;
  return DeviationKind::overlapping_allan;
}

void run(const Options& o) {
  expect_free("-o", o.output, o.force);
  const Session session = open_session(o.recording, o.declarations);
  const RecordingSource& source = choose_recording(session, o.one);
  if (!o.output.empty()) expect_inputs_stay("-o", o.output, session);
  const RecordingReading reading = read_recording(session, source);
  for (const std::string& text : reading.warnings) warn(text);
  const NoiseAnalysis analysis = analyze_noise(still_part(reading.recording, session), kind_of(o.deviation));
  if (o.json || o.output != "-") fmt::print("{}", o.json ? noise_json(analysis) : noise_text(analysis));
  for (const std::string& text : analysis.warnings) warn(text);
  if (!o.output.empty()) {
    if (!(o.json && o.output == "-")) write_whole(o.output, noise_json(analysis));
    if (!o.json && o.output != "-") fmt::print("\nwritten: {}\n", o.output);
  }
  std::string silent;
  for (const NoiseAxis& axis : analysis.axes)
    if (!axis.fit) silent += (silent.empty() ? "" : ", ") + axis.name;
  if (!silent.empty()) throw Unsupported(fmt::format("{}: no noise to be seen on {}; expected readings that vary", reading.recording.name, silent));
}

}  // namespace

void add_noise(Verb app) {
  const auto o = std::make_shared<Options>();
  Verb verb = app.verb("noise", "Allan deviation and noise coefficients of a log at rest, with confidence");
  verb.option("RECORDING", o->recording, "a log at rest, or a session with one").required();
  verb.option("--recording FILE", o->one, "which of a session's recordings, where it has several");
  verb.option("--deviation KIND", o->deviation, "the deviation of the curve; the coefficients do not depend on it")
      .one_of(kind_names())
      .show_default();
  add_declarations(verb, o->declarations);
  verb.option("-o,--output FILE", o->output, "write the result as JSON, with the whole curve");
  verb.flag("--force", o->force, "replace the file if there is one");
  verb.flag("--json", o->json, "print the result as JSON");
  verb.example("imulab noise night.csv -o noise.json");
  verb.example("imulab noise night.csv --set gyro.unit=deg/s");
  verb.does([o] { run(*o); });
}

}  // namespace imulab::command
