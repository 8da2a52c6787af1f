#include "apps/imulab/command.hpp"
#include "apps/imulab/files.hpp"
#include "apps/imulab/inspected.hpp"
#include "apps/imulab/report.hpp"
#include "apps/imulab/session_recording.hpp"
#include "imulab/core/error.hpp"
#include "imulab/estimate/method.hpp"
#include "imulab/io/calibration/file.hpp"
#include "imulab/io/recording/file.hpp"
#include "imulab/io/result/calibration.hpp"
#include "imulab/io/result/live.hpp"
#include "imulab/io/text/file.hpp"
#include "imulab/io/text/terminal.hpp"
#include "imulab/model/coefficient.hpp"
#include "imulab/model/requirement.hpp"
#include "imulab/report/calibration_page.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <map>
#include <memory>
#include <optional>

namespace imulab::command {

namespace {

struct CalibrateArguments {
  std::string session, method, output, terms = "auto", recording, curves, report;
  std::optional<std::string> require;
  std::vector<std::string> declarations;
  bool json = false, stepwise = false, force = false, verbose = false;
};

/// "auto" and "full" are empty; else selectors separated by commas.
std::vector<CoefficientIndex> parse_terms(const std::string& terms) {
  std::vector<CoefficientIndex> indices;
  if (terms == "auto" || terms == "full") return indices;
  for (std::size_t begin = 0; begin <= terms.size();) {
    const std::size_t end = std::min(terms.find(',', begin), terms.size());
    for (const CoefficientIndex index : errors_at("--terms", [&] { return select_coefficients(terms.substr(begin, end - begin)); }))
      indices.push_back(index);
    begin = end + 1;
  }
  return indices;
}

/// All of the session's if the method takes several; --recording chooses one. Leaves the steps of these in `session`.
std::vector<Recording> read_recordings(Session& session, const Method& method, const std::string& chosen, std::vector<std::string>& warnings) {
  if (!method.takes_several || !chosen.empty() || session.recordings.empty()) session.recordings = {choose_recording(session, chosen)};
  std::erase_if(session.steps, [&](const Step& step) {
    return std::none_of(session.recordings.begin(), session.recordings.end(), [&](const RecordingSource& r) { return r.file == step.recording; });
  });
  std::vector<Recording> recordings;
  for (const RecordingSource& source : session.recordings) {
    RecordingReading reading = read_recording(session, source);
    warnings.insert(warnings.end(), reading.warnings.begin(), reading.warnings.end());
    recordings.push_back(std::move(reading.recording));
  }
  for (const std::string& text : warnings) warn(text);
  return recordings;
}

CalibrationOptions options_of(const CalibrateArguments& arguments, const Method& method, const std::vector<Recording>& recordings,
                              const std::vector<Requirement>& requirements = {}) {
  if (arguments.stepwise && !method.takes_stepwise) throw Error("--stepwise: only the method whole-unit has steps");
  if (!arguments.curves.empty() && !method.takes_curves) throw Error("--curves: only the method hybrid has convergence curves");
  if (arguments.terms == "full" && !method.takes_full) throw Error("--terms full: only the method whole-unit takes it");
  CalibrationOptions options;
  options.terms = parse_terms(arguments.terms);
  options.handheld.requirements = requirements;
  options.whole_unit = {.full = arguments.terms == "full", .stepwise = arguments.stepwise};
  constexpr double points = 500;  // of a curve: enough for a screen
  if ((!arguments.curves.empty() || !arguments.report.empty()) && method.takes_curves && !recordings.empty())
    options.hybrid.curve_interval = static_cast<double>(recordings.front().size()) * recordings.front().interval_s / points;
  return options;
}

/// The options that shape the result, as they were given.
std::map<std::string, std::string> options_used(const CalibrateArguments& arguments) {
  std::map<std::string, std::string> used{{"terms", arguments.terms}};
  if (!arguments.recording.empty()) used["recording"] = arguments.recording;
  if (arguments.stepwise) used["stepwise"] = "true";
  return used;
}

std::string report_of(const CalibrationResult& result, const Session& session, const std::vector<Recording>& recordings) {
  CalibrationReport report{.result = result, .session = session};
  for (const Recording& recording : recordings) report.recordings.push_back(evidence_of(result.calibration, session, recording, recordings.size()));
  return calibration_page(report);
}

/// Calibrates a session and writes the files that are named. Throws as the estimators do. For a method other than hybrid the result is the
/// calibration alone.
CalibrationResult calibrate(const CalibrateArguments& arguments) {
  const Method& chosen = method(arguments.method);
  options_of(arguments, chosen, {});  // errors of the command are reported before anything is read
  const std::vector<Requirement> requirements =
      arguments.require ? errors_at("--require", [&] { return parse_requirements(*arguments.require); }) : std::vector<Requirement>{};
  Session session = open_session(arguments.session, arguments.declarations);
  expect_free("-o", arguments.output, arguments.force);
  errors_at(session.file + ": [site]", [&] { session.site.gravity(); });  // if neither gravity nor the latitude is known
  std::vector<std::string> warnings;
  const std::vector<Recording> recordings = read_recordings(session, chosen, arguments.recording, warnings);
  CalibrationResult result;
  try {
    Progress progress("calibrating");
    CalibrationOptions calibration_options = options_of(arguments, chosen, recordings, requirements);
    calibration_options.progress = [&progress](double part) { progress.report(part); };
    result = imulab::calibrate(chosen, {session, recordings}, calibration_options);
  } catch (const TermsError& e) {
    throw Error(fmt::format("--terms: {}", e.what()));
  }
  Calibration& calibration = result.calibration;
  add_provenance(calibration, session, recordings);
  calibration.options = options_used(arguments);
  Quality& quality = calibration.quality;
  for (const Requirement& requirement : requirements) quality.requirements.push_back(assess(calibration, requirement));
  for (const std::string& text : quality.warnings) warn(text);
  quality.warnings.insert(quality.warnings.begin(), warnings.begin(), warnings.end());
  if (!arguments.output.empty()) write_whole(arguments.output, calibration_text(calibration));
  if (!arguments.curves.empty()) write_whole(arguments.curves, curves_csv(result));
  if (!arguments.report.empty()) write_whole(arguments.report, report_of(result, session, recordings));
  return result;
}

/// Throws Unsupported, exit code 1, where the result is not what was asked for; it has been written all the same.
void expect_supported(const CalibrationResult& result) {
  const Quality& quality = result.calibration.quality;
  const std::string missing = result.missing_turns.empty() ? "" : "\n  what helps most: " + turns_text(result.missing_turns);
  if (!quality.converged) throw Unsupported("the fit did not converge: neither its values nor its uncertainties can be relied on");
  std::string list;
  for (const std::string& name : quality.unobservable) list += " " + name;
  if (!list.empty()) throw Unsupported(fmt::format("the data do not determine:{}; they keep their starting values{}", list, missing));
  for (const RequirementResult& r : quality.requirements)
    if (!r.met) list += fmt::format("{}{}", list.empty() ? "" : ", ", r.text);
  if (!list.empty()) throw Unsupported("not reached: " + list + missing);
}

}  // namespace

void add_calibrate(Verb app) {
  const auto a = std::make_shared<CalibrateArguments>();
  Verb verb = app.verb("calibrate", "Compute a calibration and its uncertainties from a session");
  verb.option("session", a->session, "a session folder or its session.toml; or a recording, which is inspected first").required().reads();
  add_declarations(verb, a->declarations);
  std::vector<std::string> names;
  for (const Method& m : methods()) names.emplace_back(m.name);
  verb.option(
          "--method METHOD", a->method,
          "static: from rests alone; handheld: from rests and the rotations between them; turntable: from the table's angles; hybrid: from rests and "
          "turns in one place, without a table's angles; whole-unit: from chamber, rate table and centrifuge, all recordings together")
      .required()
      .one_of(names);
  verb.option("-o,--output FILE", a->output, "the calibration file to write; - for standard output").writes();
  verb.option("--terms TERMS", a->terms,
              "coefficients to estimate, for example accel.offset,gyro.matrix.diagonal; auto: those that the data support; full (whole-unit): "
              "all, significant or not")
      .show_default();
  verb.option("--recording FILE", a->recording, "the recording to use, if the session has several");
  verb.flag("--stepwise", a->stepwise, "whole-unit: Dai's three steps in sequence instead of the joint estimate");
  verb.option("--curves FILE", a->curves, "hybrid: a CSV file with the convergence of each coefficient and its standard uncertainty").writes();
  verb.option("--require LIMITS", a->require,
              "what the calibration is for, as in \"gyro.matrix.diagonal <= 100 ppm, accel.offset <= 200 ug\"; exit code 1 where it is not reached");
  add_report_option(verb, a->report);
  verb.flag("--force", a->force, "replace the calibration file if there is one");
  verb.flag("--json", a->json, "print the calibration file instead of the table");
  verb.flag("-v,--verbose", a->verbose, "print also values in SI, what was used, and the tests of optional terms");
  verb.example("imulab calibrate session --method handheld -o calibration.json");
  verb.example("imulab calibrate session --method hybrid --require \"gyro.offset <= 1 deg/h\"");
  verb.does([a] {
    const CalibrationResult result = calibrate(*a);
    const Calibration& calibration = result.calibration;
    if (a->json && a->output != "-") print_json(calibration_text(calibration));
    if (!a->json && a->output != "-") {
      print(calibration_summary(calibration));
      if (a->verbose) print("\n" + calibration_details(calibration, result.coarse ? &*result.coarse : nullptr));
      print(fmt::format("\n{}\n", a->output.empty() ? "not saved: no -o FILE was given" : "written: " + a->output));
    }
    expect_supported(result);
  });
}

}  // namespace imulab::command
