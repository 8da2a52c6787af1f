#include "imulab/tasks/calibrate.hpp"

#include "apps/imulab/command.hpp"
#include "apps/imulab/files.hpp"
#include "apps/imulab/inspected.hpp"
#include "apps/imulab/prior.hpp"
#include "apps/imulab/report.hpp"
#include "apps/imulab/session_recording.hpp"
#include "imulab/core/error.hpp"
#include "imulab/formats/calibration/file.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/terminal.hpp"
#include "imulab/model/requirement.hpp"
#include "imulab/results/calibration.hpp"

#include <fmt/core.h>

#include <map>
#include <memory>
#include <optional>

namespace imulab::command {

namespace {

struct CalibrateArguments {
  std::string session, method, output, terms = "auto", recording, curves, report, prior;
  std::optional<std::string> require;
  std::vector<std::string> declarations;
  bool json = false, stepwise = false, force = false, verbose = false;
};

/// Errors of the command are reported before anything is read.
CalibrationTask task_of(const CalibrateArguments& arguments, const Method& method) {
  if (arguments.stepwise && !method.takes_stepwise)
    throw Error(fmt::format("--stepwise: only the method {} has steps", names_of_methods(&Method::takes_stepwise)));
  if (!arguments.curves.empty() && !method.takes_curves)
    throw Error(fmt::format("--curves: only the method {} has convergence curves", names_of_methods(&Method::takes_curves)));
  if (arguments.terms == "full" && !method.takes_full)
    throw Error(fmt::format("--terms full: only the method {} takes it", names_of_methods(&Method::takes_full)));
  errors_at("--terms", [&] { parse_terms(arguments.terms); });
  CalibrationTask task{.method = arguments.method,
                       .terms = arguments.terms,
                       .stepwise = arguments.stepwise,
                       .curves = !arguments.curves.empty() || !arguments.report.empty()};
  if (arguments.require) task.requirements = errors_at("--require", [&] { return parse_requirements(*arguments.require); });
  return task;
}

/// The options that shape the result, as they were given.
std::map<std::string, std::string> options_used(const CalibrateArguments& arguments) {
  std::map<std::string, std::string> used{{"terms", arguments.terms}};
  if (!arguments.recording.empty()) used["recording"] = arguments.recording;
  if (arguments.stepwise) used["stepwise"] = "true";
  if (!arguments.prior.empty()) used["prior"] = arguments.prior;
  return used;
}

/// Calibrates a session and writes the files that are named. Throws as the estimators do. For a method without curves the result is the
/// calibration alone.
CalibrationResult calibrate(const CalibrateArguments& arguments) {
  const Method& chosen = method(arguments.method);
  CalibrationTask task = task_of(arguments, chosen);
  Session session = open_session(arguments.session, arguments.declarations);
  expect_free("-o", arguments.output, arguments.force);
  if (!arguments.prior.empty()) task.prior = prior_at(arguments.prior);
  errors_at(session.file + ": [site]", [&] { session.site.gravity(); });  // if neither gravity nor the latitude is known
  if (!chosen.takes_several || !arguments.recording.empty()) named_recording(session, arguments.recording);
  const SessionRecordings data = [&] {
    const Progress progress("reading");
    return read_recordings(std::move(session), chosen, arguments.recording);
  }();
  for (const std::string& text : data.warnings) warn(text);
  CalibrationResult result;
  try {
    Progress progress("calibrating");
    task.progress = [&progress](double part) { progress.report(part); };
    result = imulab::calibrate(data, task);
  } catch (const TermsError& e) {
    throw Error(fmt::format("--terms: {}", e.what()));
  }
  Calibration& calibration = result.calibration;
  {
    const Progress progress("reading");
    add_provenance(calibration, data.session, data.recordings);
  }
  calibration.options = options_used(arguments);
  Quality& quality = calibration.quality;
  for (const std::string& text : quality.warnings) warn(text);
  quality.warnings.insert(quality.warnings.begin(), data.warnings.begin(), data.warnings.end());
  if (!arguments.output.empty()) write_whole(arguments.output, calibration_text(calibration));
  if (!arguments.curves.empty()) write_whole(arguments.curves, curves_csv(result));
  if (!arguments.report.empty()) write_whole(arguments.report, calibration_page(result, data));
  return result;
}

}  // namespace

void add_calibrate(Verb app) {
  const auto a = std::make_shared<CalibrateArguments>();
  Verb verb = app.verb("calibrate", "Compute a calibration and its uncertainties from a session");
  verb.option("session", a->session,
              "a session folder or its session.toml; a recording, which is inspected first; - for a session or rows on standard input")
      .required()
      .reads();
  add_declarations(verb, a->declarations);
  std::vector<std::string> names;
  for (const Method& m : methods()) names.emplace_back(m.name);
  std::string summaries;
  for (const Method& m : methods_by_equipment()) summaries += fmt::format("{}{}: {}", summaries.empty() ? "" : "; ", m.name, m.summary);
  verb.option("--method METHOD", a->method, summaries).required().one_of(names);
  verb.option("-o,--output FILE", a->output, "the calibration file to write; - for standard output").writes();
  verb.option("--terms TERMS", a->terms,
              fmt::format("coefficients to estimate, for example accel.offset,gyro.matrix.diagonal; auto: those that the data support; full ({}): "
                          "all, significant or not",
                          names_of_methods(&Method::takes_full)))
      .show_default();
  verb.option("--recording FILE", a->recording, "the recording to use, if the session has several");
  verb.flag("--stepwise", a->stepwise, names_of_methods(&Method::takes_stepwise) + ": Dai's three steps in sequence instead of the joint estimate");
  verb.option("--curves FILE", a->curves,
              names_of_methods(&Method::takes_curves) + ": a CSV file with the convergence of each coefficient and its standard uncertainty")
      .writes();
  verb.option("--require LIMITS", a->require,
              "what the calibration is for, as in \"gyro.matrix.diagonal <= 100 ppm, accel.offset <= 200 ug\"; exit code 1 where it is not reached");
  add_prior_option(verb, a->prior);
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
    if (const std::string missing = shortcomings(result); !missing.empty()) throw Unsupported(missing);  // it has been written all the same
  });
}

}  // namespace imulab::command
