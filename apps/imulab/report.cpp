// imulab report RESULT

#include "apps/imulab/command.hpp"
#include "apps/imulab/files.hpp"
#include "imulab/error.hpp"
#include "imulab/estimate/method.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/calibration/file.hpp"
#include "imulab/formats/laboratory/file.hpp"
#include "imulab/formats/recording/reader.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/json.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/report/aided_page.hpp"
#include "imulab/report/calibration_page.hpp"
#include "imulab/report/certificate.hpp"
#include "imulab/report/comparison_page.hpp"
#include "imulab/report/extrinsics_page.hpp"
#include "imulab/report/navigation_page.hpp"
#include "imulab/report/noise_page.hpp"
#include "imulab/report/prediction_page.hpp"
#include "imulab/report/recording_page.hpp"
#include "imulab/results/summary.hpp"
#include "imulab/tasks/navigation_figures.hpp"
#include "imulab/tasks/verify.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <set>
#include <type_traits>
#include <variant>

namespace imulab::command {

namespace fs = std::filesystem;

namespace {

struct Options {
  std::string result, session_at, output, number, laboratory;
  bool json = false, certificate = false;
};

constexpr const char* pictures = "The recording, gravity and rotations before and after, the directions of gravity";

const char* reason(FileState state) {
  return state == FileState::changed ? "is not the file that was calibrated (its SHA-256 differs)" : "was not found";
}

/// The recordings of the session whose files are those that were calibrated; what is missing goes to the report.
void add_evidence(CalibrationReport& report, const Session& session, const std::set<std::string>& bad) {
  const Calibration& calibration = report.result.calibration;
  std::set<std::string> used;
  for (const SourceFile& source : calibration.sources) used.insert(source.file);
  std::vector<RecordingSource> sources;
  for (const RecordingSource& source : session.recordings) {
    bool whole = true, named = false;
    for (const auto& file : {std::optional(source.file), source.gyro.file, source.accel.file}) {
      if (!file || !used.contains(*file)) continue;
      named = true;
      whole = whole && !bad.contains(*file);
    }
    if (named && whole) sources.push_back(source);
  }
  for (const RecordingSource& source : sources) try {
      const Recording recording = read_recording(session, source).recording;
      Session with_aids = session;
      with_aids.aids = read_aids(session, source, recording).aids;
      report.recordings.push_back(evidence_of(calibration, with_aids, recording, sources.size()));
    } catch (const Error& e) {
      report.missing.push_back(fmt::format("{} of {}: {}.", pictures, source.file, e.what()));
    }
}

CalibrationReport saved_calibration(Calibration calibration, const Options& o) {
  CalibrationReport report;
  report.result.calibration = std::move(calibration);
  const Calibration& c = report.result.calibration;
  if (const Method* method = find_method(c.method); method != nullptr && method->takes_curves)
    report.missing.emplace_back("Curves over time: the calibration file does not keep them; imulab calibrate --report draws them.");
  if (c.sources.empty() || c.session_file.empty()) {
    report.missing.push_back(fmt::format("{}: the file names no recordings with their hashes.", pictures));
    return report;
  }
  if (o.session_at.empty() && c.session_file == c.sources.front().file) {
    report.missing.push_back(
        fmt::format("{}: the calibration is of {} without a session; imulab calibrate --report draws them.", pictures, c.session_file));
    return report;
  }
  const fs::path place = find_session(o.session_at, o.result, c.session_file);
  std::set<std::string> bad;
  const std::vector<VerifiedFile> files = verify_sources(c, place);
  for (std::size_t k = 0; k < files.size(); ++k) {
    if (files[k].state == FileState::unchanged) continue;
    report.missing.push_back(fmt::format("{}: {} {}{}.", pictures, files[k].file.string(), reason(files[k].state),
                                         files[k].state == FileState::missing ? "; --session-at names its new place" : ""));
    if (k == 0) return report;  // without the session nothing is known of the recordings
    bad.insert(c.sources[k - 1].file);
  }
  try {
    report.session = read_session(place);
  } catch (const Error& e) {
    report.missing.push_back(fmt::format("{}: {}.", pictures, e.what()));
    return report;
  }
  will_read_files_of(*report.session);
  add_evidence(report, *report.session, bad);
  return report;
}

// Pages say what the JSON of an earlier version, or of a stream, lacks.

std::string saved_budget(const std::string& name, BudgetSummary summary, const SavedAnswer& saved) {
  std::vector<std::string> missing;
  if (summary.budget.time.size() < 2)
    missing.emplace_back("Errors and shares over time: the JSON has the end alone; imulab budget --report draws them.");
  std::vector<LossCurve> curves = loss_curves(summary.budget, saved.conclusion.requirements);
  return budget_page({.mission = name,
                      .summary = std::move(summary),
                      .missing = std::move(missing),
                      .warnings = saved.warnings,
                      .conclusion = saved.conclusion,
                      .curves = std::move(curves)});
}

std::string saved_navigation(NavigationSummary sessions, const SavedAnswer& saved) {
  const bool all = std::all_of(sessions.begin(), sessions.end(), [](const NavigatedSession& s) { return s.navigated.track.size() > 1; });
  std::vector<std::string> missing;
  if (!all) missing.emplace_back("Track and errors over time: the JSON has the end alone; imulab navigate --report draws them.");
  return navigation_page(
      {.sessions = std::move(sessions), .missing = std::move(missing), .warnings = saved.warnings, .conclusion = saved.conclusion});
}

std::string saved_compensation(const CompensationSummary& summary) {
  const bool all = std::all_of(summary.files.begin(), summary.files.end(), [](const CompensatedFile& f) { return f.overview.has_value(); });
  return compensation_page(
      summary, all ? std::vector<std::string>{} : std::vector<std::string>{"Rates and forces over time: of a stream only counts are kept."});
}

std::string page_of(SavedAnswer saved, const Options& o) {
  const Conclusion& conclusion = saved.conclusion;
  const std::string name = o.result == "-" ? "standard input" : fs::path(o.result).filename().string();
  return std::visit(
      [&](auto& result) -> std::string {
        using Result = std::decay_t<decltype(result)>;
        if constexpr (std::is_same_v<Result, Calibration>) {
          const CalibrationReport report = saved_calibration(std::move(result), o);
          return errors_at(name, [&] { return calibration_page(report); });
        }
        if constexpr (std::is_same_v<Result, ComparisonSummary>) return comparison_page(result, saved.warnings);
        if constexpr (std::is_same_v<Result, ResultComparison>) return result_comparison_page(result, conclusion, saved.warnings);
        if constexpr (std::is_same_v<Result, PredictionSummary>)
          return prediction_page({.procedure = name, .summary = std::move(result), .conclusion = conclusion});
        if constexpr (std::is_same_v<Result, PlanSummary>) return plan_page(result, conclusion);
        if constexpr (std::is_same_v<Result, BudgetSummary>) return saved_budget(name, std::move(result), saved);
        if constexpr (std::is_same_v<Result, NavigationSummary>) return saved_navigation(std::move(result), saved);
        if constexpr (std::is_same_v<Result, AidedSummary>) return aided_page(result.session, result.navigation, conclusion, saved.warnings);
        if constexpr (std::is_same_v<Result, Extrinsics>) return extrinsics_page(result, conclusion);
        if constexpr (std::is_same_v<Result, CompensationSummary>) return saved_compensation(result);
        if constexpr (std::is_same_v<Result, NoiseAnalysis> || std::is_same_v<Result, NoiseBatch>) return noise_page(result, conclusion);
      },
      saved.result);
}

std::string certificate_of(const Options& o) {
  Certificate certificate{.number = o.number, .file = input_name(o.result)};
  if (!o.laboratory.empty()) certificate.laboratory = read_laboratory(o.laboratory);
  const MappedFile mapped(o.result, Content::settings);  // once: it may be standard input
  SavedResult saved = parse_result(mapped.text(), certificate.file);
  if (!std::holds_alternative<Calibration>(saved))
    throw Error("--certificate: " + certificate.file + " is no calibration; expected calibration.json");
  certificate.sha256 = sha256(mapped.text());
  certificate.report = saved_calibration(std::get<Calibration>(std::move(saved)), o);
  return errors_at(certificate.file, [&] { return certificate_page(certificate); });
}

void run(const Options& o) {
  if (o.json && o.output == "-") throw Error("--json: standard output has the page; expected -o FILE");
  if (!o.certificate && !o.number.empty()) throw Error("--number: belongs to a certificate; expected --certificate");
  if (!o.certificate && !o.laboratory.empty()) throw Error("--laboratory: belongs to a certificate; expected --certificate");
  if (o.certificate && o.number.empty()) warn("the certificate has no number, which would identify it; expected --number N");
  write_whole(o.output, o.certificate ? certificate_of(o) : page_of(read_answer(o.result), o));
  if (o.json) print_json({{{"file", o.output}}}, {Verdict::none, "written: " + o.output});
  if (!o.json && o.output != "-") print(fmt::format("written: {}\n", one_line(o.output)));
}

}  // namespace

void add_report(Verb& app) {
  const auto o = std::make_shared<Options>();
  Verb& verb = app.verb("report", "Show a saved result as a page: one HTML file, self-contained");
  verb.option("RESULT", o->result,
              "calibration.json, noise.json, extrinsics.json, or the --json output of compare, predict, plan, navigate, budget or compensate; - for "
              "standard input")
      .required()
      .reads();
  verb.option("-o,--output FILE", o->output, "the page to write; - for standard output").required().writes();
  verb.option("--session-at PLACE", o->session_at, "the session's folder or file, if it has moved").reads();
  verb.option("--certificate", o->certificate, "of a calibration: write a calibration certificate, two A4 pages and an appendix");
  verb.option("--number N", o->number, "the certificate's number");
  verb.option("--laboratory FILE", o->laboratory,
              "what the laboratory declares: name, address, customer, conditions (docs/reference/calibration-file.md)")
      .reads();
  verb.option("--json", o->json, "print what was written as JSON");
  verb.example("imulab report calibration.json -o calibration.html");
  verb.does = [o] { run(*o); };
}

}  // namespace imulab::command
