#include "imulab/tasks/calibrate.hpp"

#include "imulab/coefficient.hpp"
#include "imulab/error.hpp"
#include "imulab/estimate/kernel/plausibility.hpp"
#include "imulab/extrinsics.hpp"
#include "imulab/files.hpp"
#include "imulab/fleet.hpp"
#include "imulab/fleet/statistics/prior.hpp"
#include "imulab/fleet/store/server.hpp"
#include "imulab/formats/calibration/file.hpp"
#include "imulab/formats/recording/reader.hpp"
#include "imulab/grade.hpp"
#include "imulab/model/finding_table.hpp"
#include "imulab/recording/validate.hpp"
#include "imulab/report/calibration_page.hpp"
#include "imulab/results/calibration.hpp"
#include "imulab/results/live.hpp"
#include "imulab/tasks/inspect.hpp"
#include "imulab/tasks/usable.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

namespace imulab {
namespace {

CalibrationOptions options_of(const CalibrationTask& task, const Method& method, const std::vector<Recording>& recordings) {
  if (task.terms == "full" && !method.takes_full) throw TermsError("full: only the method whole-unit takes it");
  CalibrationOptions options;
  options.terms = parse_terms(task.terms);
  options.effects = task.effects;
  options.handheld.requirements = task.requirements;
  options.whole_unit = {.full = task.terms == "full", .stepwise = task.stepwise};
  options.progress = task.progress;
  options.reference = task.reference;
  constexpr double points = 500;  // of a curve: enough for a screen
  if (task.curves && method.takes_curves && !recordings.empty())
    options.hybrid.curve_interval = static_cast<double>(recordings.front().size()) * recordings.front().interval_s / points;
  return options;
}

/// The prior, and what is said of it.
void add_prior(Calibration& calibration, const FleetPrior& prior) {
  Quality& quality = calibration.quality;
  if (!quality.converged) return;
  const PriorUse use = take_prior(calibration, prior);
  if (!use.taken) {
    quality.findings.add<Code::outlier_of_fleet>(Subject{prior.fleet}, use.distance, use.p_value);
    return;
  }
  quality.findings.add<Code::prior_used>(prior.units, Subject{prior.fleet}, use.distance, use.p_value);
  std::string filled;
  for (const CoefficientIndex index : use.filled) {
    filled += fmt::format(" {}", coefficient(index).name);
    std::erase(quality.unobservable, std::string(coefficient(index).name));
  }
  if (!filled.empty()) quality.findings.add<Code::from_fleet>(filled);
}

/// The options that shape the result, as they were given.
std::map<std::string, std::string> options_used(const CalibrateOptions& o) {
  std::map<std::string, std::string> used{{"terms", o.terms}};
  if (o.effects != "table") used["effects"] = o.effects;
  if (!o.recording.empty()) used["recording"] = o.recording;
  if (o.stepwise) used["stepwise"] = "true";
  if (o.reference) used["reference"] = *o.reference;
  if (o.reference_calibration) used["calibration"] = *o.reference_calibration;
  if (!o.prior.empty()) used["prior"] = fleet::shown_store(o.prior);
  return used;
}

ReferenceImu reference_of(const CalibrateOptions& o) {
  ReferenceImu out{.imu = *o.reference};
  if (!o.reference_calibration) return out;
  if (std::ranges::find(grades(), *o.reference_calibration, &Grade::name) != grades().end()) {
    out.grade = *o.reference_calibration;
    return out;
  }
  out.calibration = read_calibration(*o.reference_calibration);
  expect_usable(*out.calibration, *o.reference_calibration, false, "--calibration navigation");
  return out;
}

}  // namespace

Verb& declare(Verb& command, CalibrateOptions& o) {
  Verb& verb = command.verb("calibrate", "Compute a calibration and its uncertainties from a session");
  verb.option("session", o.session,
              "a session folder or its session.toml; a recording, which is inspected first; - for a session or rows on standard input")
      .required()
      .reads();
  verb.option("more", o.more, "further sessions or recordings of the same IMU, calibrated as one with the first")
      .takes_several(0)
      .reads()
      .of_command();
  std::string summaries;
  for (const Method& m : methods_by_equipment()) summaries += fmt::format("{}{}: {}", summaries.empty() ? "" : "; ", m.name, m.summary);
  verb.option("--method METHOD", o.method, summaries).required().one_of(offered_methods());
  verb.option("-o,--output FILE", o.output, "the calibration file to write; - for standard output").writes().keeps_existing().of_command();
  verb.option("--terms TERMS", o.terms,
              fmt::format("coefficients to estimate, for example accel.offset,gyro.matrix.diagonal; auto: those that the data support; full ({}): "
                          "all, significant or not",
                          names_of_methods(&Method::takes_full)))
      .show_default();
  effects_option(verb, o.effects);
  verb.option("--recording FILE", o.recording, "the recording to use, if the session has several");
  verb.option("--stepwise", o.stepwise, names_of_methods(&Method::takes_stepwise) + ": Dai's three steps in sequence instead of the joint estimate");
  verb.option(
          "--curves FILE", o.curves,
          names_of_methods(&Method::takes_curves) +
              ": a CSV file with the convergence of each coefficient, or the departures of the offsets over time, each with its standard uncertainty")
      .writes()
      .of_command();
  verb.option("--require LIMITS", o.require,
              "limits that the uncertainties must meet, as in \"gyro.matrix.diagonal <= 100 ppm, accel.bias <= 200 ug\"; exit code 1 otherwise");
  verb.option("--reference NAME", o.reference, names_of_methods(&Method::takes_reference) + ": the better IMU, as [[recording]] names it by imu");
  verb.option("--calibration FILE", o.reference_calibration, "of the reference: its calibration, or the name of its grade (default: navigation)");
  prior_option(verb, o.prior);
  report_option(verb, o.report);
  topics_option(verb, o.topics).of_command();
  declarations_option(verb, o.declarations);
  json_option(verb, o.json, "print the calibration file instead of the table");
  verb.option("-v,--verbose", o.verbose, "also print values in SI, the rests and rotations used, and the tests of optional terms").of_command();
  verb.example("imulab calibrate session --method handheld -o calibration.json");
  verb.example("imulab calibrate session --method hybrid --require \"gyro.bias <= 1 deg/h\"");
  return verb;
}

std::vector<std::string> offered_methods(bool (*offered)(const Method& method)) {
  std::vector<std::string> names;
  for (const Method& m : methods())
    if (offered == nullptr || offered(m)) names.emplace_back(m.name);
  return names;
}

CalibrationTask task_of(const CalibrateOptions& o) {
  const Method& chosen = method(o.method);
  const auto only = [](bool Method::*capability, const char* has) { return fmt::format("only the method {} {}", names_of_methods(capability), has); };
  if (o.stepwise && !chosen.takes_stepwise) throw OptionError("stepwise", only(&Method::takes_stepwise, "has steps"));
  if (!o.curves.empty() && !chosen.takes_curves) throw OptionError("curves", only(&Method::takes_curves, "has curves over time"));
  if (o.reference && !chosen.takes_reference) throw OptionError("reference", only(&Method::takes_reference, "has one"));
  if (o.reference_calibration && !chosen.takes_reference) throw OptionError("calibration", only(&Method::takes_reference, "has a reference"));
  if (!o.reference && chosen.takes_reference)
    throw OptionError("reference", "is missing; expected the better IMU, as a [[recording]] of the session names it by imu");
  if (o.terms == "full" && !chosen.takes_full) throw OptionError("terms full", only(&Method::takes_full, "takes it"));
  errors_of_option("terms", [&] { parse_terms(o.terms); });
  CalibrationTask task{.method = o.method,
                       .terms = o.terms,
                       .effects = o.effects == "table",
                       .stepwise = o.stepwise,
                       .curves = !o.curves.empty() || !o.report.empty()};
  if (o.require) task.requirements = errors_of_option("require", [&] { return parse_requirements(*o.require); });
  if (o.reference) task.reference = reference_of(o);
  task.prior = read_prior(o.prior);
  return task;
}

std::optional<FleetPrior> read_prior(const std::string& file) {
  if (file.empty()) return std::nullopt;
  FleetStore store(file);
  return errors_of_option("prior", [&] { return fleet_prior(store); });
}

VerbOption& effects_option(Verb& verb, std::string& effects) {
  return verb
      .option("--effects WHICH", effects,
              "errors of an IMU beyond the sensor model, such as asymmetry, hysteresis and drift: estimated under "
              "their priors (table), or taken as absent (none)")
      .one_of({"table", "none"})
      .show_default();
}

std::vector<CoefficientIndex> parse_terms(std::string_view terms) {
  std::vector<CoefficientIndex> indices;
  if (terms == "auto" || terms == "full") return indices;
  for (std::size_t begin = 0; begin <= terms.size();) {
    const std::size_t end = std::min(terms.find(',', begin), terms.size());
    const std::vector<CoefficientIndex> selected = select_coefficients(terms.substr(begin, end - begin));
    indices.insert(indices.end(), selected.begin(), selected.end());
    begin = end + 1;
  }
  return indices;
}

SessionRecordings read_recordings(Session session, const std::string& chosen, bool several_imus) {
  SessionRecordings data{std::move(session), {}, {}};
  Session& s = data.session;
  if (!chosen.empty() || s.recordings.empty()) s.recordings = {RecordingSource(choose_recording(s, chosen))};
  for (const RecordingSource& source : s.recordings)
    if (source.imu != s.recordings.front().imu && !several_imus)
      throw Error(fmt::format("{}: its recordings are of several IMUs ({}, {}); expected one chosen by recording", s.file, s.recordings.front().imu,
                              source.imu));
  std::erase_if(s.steps, [&](const Step& step) {
    return std::none_of(s.recordings.begin(), s.recordings.end(), [&](const RecordingSource& r) { return r.file == step.recording; });
  });
  for (const RecordingSource& source : s.recordings) {
    RecordingReading reading = read_recording(s, source);
    data.warnings.insert(data.warnings.end(), reading.warnings.begin(), reading.warnings.end());
    data.recordings.push_back(std::move(reading.recording));
  }
  return data;
}

SessionRecordings given_recordings(Session session, std::vector<Recording> recordings) {
  session = declared_session(std::move(session), recordings);
  return {std::move(session), std::move(recordings), {}};
}

void expect_gravity(const Session& session, const Method& method) {
  if (!method.takes_aids && !method.takes_reference) errors_at(session.file + ": [site]", [&] { session.site.gravity(); });
}

namespace {

/// The aids of every recording with their records; those without a file that go with all are there once.
std::vector<Aid> aids_of_all(const SessionRecordings& data, std::vector<std::string>& warnings) {
  std::vector<Aid> out;
  for (std::size_t k = 0; k < data.recordings.size(); ++k) {
    const RecordingSource source = data.session.source_of(data.recordings[k].name);
    AidsReading reading = read_aids(data.session, source, data.recordings[k]);
    for (Aid& aid : reading.aids)
      if (k == 0 || !aid.recording.empty()) out.push_back(std::move(aid));
    warnings.insert(warnings.end(), reading.warnings.begin(), reading.warnings.end());
  }
  return out;
}

}  // namespace

CalibrationResult calibrate(const SessionRecordings& data, const CalibrationTask& task) {
  const Method& chosen = method(task.method);
  Session session = data.session;
  std::vector<std::string> warnings;
  if (chosen.takes_aids) session.aids = aids_of_all(data, warnings);
  const auto calibrated = [&](const Session& of) { return calibrate(chosen, {of, data.recordings}, options_of(task, chosen, data.recordings)); };
  CalibrationResult result = calibrated(session);
  if (task.prior) {
    const PriorUse sizes = fit_of_sizes(result.calibration, *task.prior);
    if (sizes.taken) result = calibrated(with_sizes(session, *task.prior));
    if (sizes.p_value < 1 && !sizes.taken)
      result.calibration.quality.findings.add<Code::outlier_of_fleet>(Subject{task.prior->fleet}, sizes.distance, sizes.p_value);
    else
      add_prior(result.calibration, *task.prior);
  }
  Quality& quality = result.calibration.quality;
  quality.findings.prepend(Severity::warning, warnings);
  for (const Requirement& requirement : task.requirements) quality.requirements.push_back(assess(result.calibration, requirement));
  return result;
}

CalibratedImu calibrated_imu(const std::shared_ptr<const SessionRecordings>& data, const CalibrateOptions& o, const CalibrationTask& task,
                             bool from_files) {
  CalibratedImu out{data, {}};
  try {
    out.result = calibrate(*data, task);
  } catch (const TermsError& e) {
    throw OptionError("terms", e.what());
  }
  if (from_files) add_provenance(out.result.calibration, data->session, data->recordings);
  out.result.calibration.options = options_used(o);
  return out;
}

AnswerOf<CalibrationResult> calibration_answer(CalibratedImu imu) {
  std::vector<std::string> own = imu.result.calibration.quality.findings.warnings();
  imu.result.calibration.quality.findings.prepend(Severity::warning, imu.data->warnings);
  const auto result = std::make_shared<const CalibrationResult>(std::move(imu.result));
  return {{.json = [result] { return calibration_text(result->calibration); },
           .table =
               [result](bool details) {
                 const Calibration& c = result->calibration;
                 return calibration_summary(c) + (details ? "\n" + calibration_details(c, result->coarse ? &*result->coarse : nullptr) : "");
               },
           .page = [result, data = imu.data] { return calibration_page(*result, *data); },
           .warnings = std::move(own),
           .shortcomings = shortcomings(*result),
           .conclusion = conclusion_of(result->calibration),
           .printed = [result] { return calibration_document(result->calibration); }},
          result};
}

std::size_t estimate_jointly(const std::vector<std::pair<std::string, CalibratedImu*>>& all, const std::function<void(double)>& progress) {
  std::vector<BodyImu> imus;
  std::vector<CalibrationResult*> results;
  for (const auto& [name, imu] : all) {
    const Calibration& c = imu->result.calibration;
    if (method(c.method).takes_aids || c.frame != BodyFrame::accelerometers) return 0;  // errors of the aids or the rig are in common
    const std::vector<Recording>& recordings = imu->data->recordings;
    const std::string unfit = c.quality.verdict != Verdict::good                                          ? "its calibration alone is not good"
                              : recordings.size() != 1                                                    ? "it has several recordings"
                              : recordings.front().gyro[0].empty() || recordings.front().accel[0].empty() ? "it lacks gyros or accelerometers"
                                                                                                          : "";
    if (!unfit.empty()) {
      imu->result.calibration.quality.findings.add<Code::not_joint>(unfit);
      continue;
    }
    imus.push_back({.name = name,
                    .recording = imu->data->recordings.front(),
                    .calibration = c,
                    .grade = imu->data->session.imu.grade.value_or("mems"),
                    .clock_zero_ns = imu->data->session.source_of(imu->data->recordings.front().name).time.zero_ns()});
    results.push_back(&imu->result);
  }
  std::string problem;
  try {
    const std::vector<Calibration> jointly = calibrate_jointly(imus, progress);
    for (std::size_t k = 0; k < jointly.size(); ++k) {
      Calibration& c = results[k]->calibration = jointly[k];
      for (RequirementResult& r : c.quality.requirements) r = assess(c, parse_requirements(r.text).front());
    }
    return jointly.front().quality.findings.has(Code::imus_contradict) ? 0 : jointly.size();
  } catch (const Unsupported& e) {
    problem = e.what();
  } catch (const Error& e) {
    problem = e.what();
  }
  for (CalibrationResult* result : results) result->calibration.quality.findings.add<Code::not_joint>(problem);
  return 0;
}

std::string shortcomings(const CalibrationResult& result) {
  const Quality& quality = result.calibration.quality;
  const std::string missing = result.missing_turns.empty() ? "" : "\n  what helps most: " + turns_text(result.missing_turns);
  const std::string unreliable = quality.converged ? "" : "the fit did not converge: neither its values nor its uncertainties can be relied on";
  if (!quality.converged && quality.unobservable.empty()) return unreliable;
  if (const std::string far = kernel::scale_far_from_unit(result.calibration.model); !far.empty()) return far;
  if (!quality.unobservable.empty())
    return fmt::format("the data do not determine: {}; they keep their starting values{}{}", fmt::join(quality.unobservable, " "),
                       unreliable.empty() ? "" : "; " + unreliable, missing);
  std::vector<std::string> unmet, doubted;
  for (const RequirementResult& r : quality.requirements) {
    if (r.met) continue;
    if (r.reached <= r.limit && quality.verdict == Verdict::doubtful)
      doubted.push_back(r.text);
    else
      unmet.push_back(r.reached <= r.limit ? fmt::format("{} ({})", r.text, r.note) : r.text);
  }
  if (!unmet.empty()) return fmt::format("not reached: {}{}", fmt::join(unmet, ", "), missing);
  return doubted.empty() ? "" : fmt::format("a doubtful result meets no requirement: {}", fmt::join(doubted, ", "));
}

std::string calibration_page(const CalibrationResult& result, const SessionRecordings& data) {
  CalibrationReport report{.result = result, .session = data.session};
  std::vector<std::string> said;  // already
  Session session = data.session;
  session.aids = aids_of_all(data, said);
  const auto reference = result.calibration.options.find("reference");  // the calibration is not its
  for (const Recording& recording : data.recordings)
    if (reference == result.calibration.options.end() || session.source_of(recording.name).imu != reference->second)
      report.recordings.push_back(evidence_of(result.calibration, session, recording, data.recordings.size()));
  return calibration_page(report);
}

}  // namespace imulab
