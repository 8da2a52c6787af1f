#include "imulab/tasks/noise.hpp"

#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/noise/data_sheet.hpp"
#include "imulab/formats/recording/reader.hpp"
#include "imulab/formats/recording/stored.hpp"
#include "imulab/noise/noise_analysis.hpp"
#include "imulab/report/noise_page.hpp"
#include "imulab/results/noise.hpp"
#include "imulab/results/noise_requirement.hpp"
#include "imulab/tasks/inspect.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace imulab {
namespace {

NoiseOptions options_of(const NoiseVerbOptions& o) {
  NoiseOptions out{.kind = deviation_named(o.deviation), .remove_temperature = o.remove_temperature};
  if (o.model) out.model = errors_of_option("model", [&] { return parse_noise_terms(*o.model); });
  for (const auto& [name, given] : {std::pair("horizon", o.horizon_s), {"confidence", o.confidence}})
    if (given && !o.bound) throw OptionError(name, "is of a bound; expected --bound as well");
  if (o.bound) out.bound = BoundOptions{o.horizon_s.value_or(BoundOptions{}.horizon_s), o.confidence.value_or(BoundOptions{}.confidence)};
  return out;
}

/// The analysis of a log beside the data sheet of the options, if they have one.
std::shared_ptr<const NoiseAnalysis> compared(NoiseAnalysis analysis, const NoiseVerbOptions& o) {
  if (o.datasheet) analysis.sheet = errors_of_option("datasheet", [&] { return compare_with_sheet(analysis, read_data_sheet(*o.datasheet)); });
  add_moving(analysis, o.moving_inputs);
  return std::make_shared<const NoiseAnalysis>(std::move(analysis));
}

/// Axes without noise are an answer that the log does not give.
std::string shortcomings(const NoiseAnalysis& analysis) {
  std::string silent;
  for (const NoiseAxis& axis : analysis.axes)
    if (!axis.fit) silent += (silent.empty() ? "" : ", ") + axis.name;
  return silent.empty() ? "" : fmt::format("{}: no noise to be seen on {}; expected readings that vary", analysis.recording, silent);
}

std::vector<RequirementResult> assessed(const std::vector<NoiseAnalysis>& logs, const NoiseVerbOptions& o) {
  if (!o.require) return {};
  return errors_of_option("require", [&] { return assess(logs, *o.require); });
}

/// Doubtful where an axis shows no noise, or the spectrum is not that of the fitted terms.
Conclusion conclusion_of(const NoiseAnalysis& analysis, const NoiseVerbOptions& o) {
  bool good = true, fits = true;
  for (const NoiseAxis& axis : analysis.axes) good = good && axis.fit && axis.fit->accepted(), fits = fits && (!axis.fit || axis.fit->accepted());
  std::string headline = noise_headline(analysis);
  if (!fits) headline += "; the spectrum of some axes is not that of the terms";
  return conclude(good ? Verdict::good : Verdict::doubtful, std::move(headline), assessed({analysis}, o));
}

/// What is missing, or what is not met.
std::string either(const std::string& missing, const Conclusion& conclusion) {
  const std::string missed = missed_requirements(conclusion);
  return missing + (missing.empty() || missed.empty() ? "" : "; ") + missed;
}

AnswerOf<NoiseAnalysis> answer_of(const std::shared_ptr<const NoiseAnalysis>& analysis, const Conclusion& conclusion,
                                  std::function<std::string()> page) {
  return {{.json = [analysis] { return noise_json(*analysis); },
           .table = [analysis](bool) { return noise_text(*analysis); },
           .page = std::move(page),
           .warnings = analysis->warnings,
           .shortcomings = either(shortcomings(*analysis), conclusion),
           .conclusion = conclusion},
          analysis};
}

/// `source`: where it has the accelerometers in a table of their own, reading joins them.
AnswerOf<NoiseAnalysis> analyzed(const RecordingView& recording, const StillRange& still, const RecordingSource& source, const NoiseVerbOptions& o) {
  NoiseOptions options = options_of(o);
  options.accel_joined = source.accel.file || source.accel.topic || source.accel.time;
  const auto analysis = compared(analyze_noise(recording, still, options), o);
  const Conclusion conclusion = conclusion_of(*analysis, o);
  if (o.report.empty()) return answer_of(analysis, conclusion, {});
  return answer_of(analysis, conclusion, [page = noise_page(*analysis, recording, still.range, conclusion)] { return page; });
}

}  // namespace

Verb& declare(Verb& command, NoiseVerbOptions& o) {
  Verb& verb = command.verb("noise", "Allan deviation and noise coefficients of a log at rest, with confidence");
  verb.option("RECORDING", o.recordings,
              "a log at rest, or a session with one; - for standard input; several: mean, spread and worst; may be absent with --datasheet")
      .reads();
  verb.option("--recording FILE", o.recording, "the recording to use, if the session has several");
  verb.option(
      "--require LIMITS", o.require,
      "limits that the log must show to be met, as in \"gyro.N <= 0.1 deg/sqrt(h), accel.B <= 20 ug\"; gyro.N is the worst axis, gyro.x.N one "
      "axis; also K, Q, R; exit code 1 otherwise");
  verb.option("--datasheet SHEET", o.datasheet,
              "values of a data sheet, as in \"gyro.N = 0.0038 deg/s/sqrt(Hz), gyro.B = 10 deg/h, accel.N = 70 ug/sqrt(Hz)\", or a TOML file with "
              "them in [noise]; compared with the log, or without a log written as its noise");
  verb.option("--model TERMS", o.model,
              "terms to fit instead of those that the spectrum requires: N,B,K or N,M1,M2, of N, Q, B, K, and processes M1, M2");
  verb.option("--bound", o.bound, "also a noise model for a filter that is not too sure: white noise, processes and walk above what the log permits");
  verb.option("--horizon S", o.horizon_s, "of the bound: longest time without aids, at most a third of the log; absent: 600").in_range(1, 1e6);
  verb.option("--confidence P", o.confidence, "of the bound: probability that the noise is below it; absent: 0.95").in_range(0.6, 0.9999);
  verb.option(
          "--moving FILE", o.moving,
          "logs of the same IMU with motors on or in motion, or results: where the factor between the noise at rest and that of a filter comes from")
      .takes_several(1)
      .reads()
      .of_command();
  verb.option("--deviation KIND", o.deviation, "deviation of the curve; the coefficients do not depend on it")
      .one_of({deviation_names.begin(), deviation_names.end()})
      .show_default();
  verb.option("--remove-temperature", o.remove_temperature, "first subtract a parabola in the temperature");
  topics_option(verb, o.topics).of_command();
  declarations_option(verb, o.declarations);
  verb.option("--in-memory MB", o.in_memory_mb,
              "use temporary files, in TMPDIR or else /var/tmp, if the columns need more than this (56 bytes per row); the result is the same")
      .in_range(1, 1e6)
      .show_default()
      .of_command();
  verb.option("-o,--output FILE", o.output, "write the result as JSON, with the whole curve").writes().keeps_existing().of_command();
  json_option(verb, o.json);
  report_option(verb, o.report);
  verb.example("imulab noise night.csv -o noise.json");
  verb.example("imulab noise night.csv --bound --horizon 60 -o noise.json");
  verb.example("imulab noise --datasheet \"gyro.N = 0.0038 deg/s/sqrt(Hz)\" -o noise.json");
  verb.example("imulab noise night.csv --moving idle.csv");
  verb.example("imulab noise unit1.csv unit2.csv unit3.csv");
  verb.example("zcat night.csv.gz | imulab noise -");
  verb.example("imulab noise night.csv --set gyro.unit=deg/s");
  return verb;
}

DeviationKind deviation_named(const std::string& name) {
  if (const auto kind = deviation_kind(name)) return *kind;
  throw Error("deviation: " + name + "; expected overlapping-allan, allan, modified-allan, hadamard, overlapping-hadamard or total");
}

AnswerOf<NoiseAnalysis> noise_answer(const Recording& recording, const Session& session, const NoiseVerbOptions& o) {
  if (o.require) errors_of_option("require", [&] { expect_noise_limits(*o.require); });
  const NoiseOptions options = options_of(o);
  const auto still = std::make_shared<const StillPart>(still_part(recording, session));
  const auto analysis = compared(analyze_noise(still->recording, *still, options), o);
  const Conclusion conclusion = conclusion_of(*analysis, o);
  return answer_of(analysis, conclusion, [still, analysis, conclusion] { return noise_page(*analysis, still->recording, still->range, conclusion); });
}

AnswerOf<NoiseAnalysis> noise_answer(const Session& session, const RecordingSource& source, const NoiseVerbOptions& o, const Tell& tell) {
  std::string why_not;
  if (std::optional<StoredReading> stored = read_stored(session, source, o.most_bytes(), why_not)) {
    for (const std::string& text : stored->warnings) tell(text);
    RepairedSamples repaired{.replaced = stored->recording.replace_outliers()};
    if (worth_filling(stored->recording.view())) repaired.filled = stored->recording.fill_short_gaps();
    const RecordingView recording = stored->recording.view();
    return analyzed(recording, still_range(recording, session, repaired), source, o);
  }
  if (!why_not.empty()) tell(why_not);
  RecordingReading reading = read_recording(session, source);
  for (const std::string& text : reading.warnings) tell(text);
  const StillPart still = still_part(std::move(reading.recording), session);
  return analyzed(still.recording, still, source, o);
}

AnswerOf<NoiseAnalysis> noise_answer(NoiseAnalysis saved, const NoiseVerbOptions& o) {
  options_of(o);  // throws for those that contradict each other
  for (const auto& [name, given] : {std::pair("bound", o.bound), {"model", o.model.has_value()}, {"remove-temperature", o.remove_temperature}})
    if (given) throw OptionError(name, "analyzes a log, and none is given; expected the log in place of its result");
  add_moving(saved, o.moving_inputs);
  const auto analysis = std::make_shared<const NoiseAnalysis>(std::move(saved));
  const Conclusion conclusion = analysis->from_data_sheet() ? Conclusion{Verdict::none, noise_headline(*analysis)} : conclusion_of(*analysis, o);
  return answer_of(analysis, conclusion, [analysis, conclusion] { return noise_page(*analysis, conclusion); });
}

AnswerOf<NoiseAnalysis> data_sheet_answer(const NoiseVerbOptions& o) {
  if (o.bound) throw OptionError("bound", "is above the spectrum of a log, and there is only a data sheet; expected a recording");
  if (o.require) throw OptionError("require", "judges a log, and there is only a data sheet; expected a recording");
  return noise_answer(errors_of_option("datasheet", [&] { return data_sheet_noise(read_data_sheet(*o.datasheet)); }), o);
}

AnswerOf<NoiseBatch> noise_answer(std::vector<NoiseAnalysis> logs, const NoiseVerbOptions& o) {
  const auto batch = std::make_shared<const NoiseBatch>(noise_batch(std::move(logs)));
  std::string missing;
  bool good = true;
  for (const NoiseAnalysis& log : batch->logs) {
    if (missing.empty()) missing = shortcomings(log);
    for (const NoiseAxis& axis : log.axes) good = good && axis.fit && axis.fit->accepted();
  }
  const Conclusion conclusion = conclude(good ? Verdict::good : Verdict::doubtful, noise_headline(*batch), assessed(batch->logs, o));
  return {{.json = [batch] { return noise_json(*batch); },
           .table = [batch](bool) { return noise_text(*batch); },
           .page = [batch, conclusion] { return noise_page(*batch, conclusion); },
           .shortcomings = either(missing, conclusion),
           .conclusion = conclusion},
          batch};
}

}  // namespace imulab
