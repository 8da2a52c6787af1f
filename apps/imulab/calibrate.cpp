#include "apps/imulab/calibrate.hpp"

#include "apps/imulab/command.hpp"
#include "apps/imulab/session_recording.hpp"
#include "imulab/core/error.hpp"
#include "imulab/estimate/handheld.hpp"
#include "imulab/estimate/static.hpp"
#include "imulab/estimate/turntable.hpp"
#include "imulab/estimate/whole_unit.hpp"
#include "imulab/io/calibration_file.hpp"
#include "imulab/io/file.hpp"
#include "imulab/io/recording_file.hpp"
#include "imulab/io/session_file.hpp"
#include "imulab/model/coefficient.hpp"
#include "imulab/recording/rests.hpp"

#include <fmt/core.h>

#include <chrono>
#include <ctime>
#include <functional>
#include <map>
#include <memory>

namespace imulab::command {

namespace {

/// `rests` are those that the session declares or the data show; the turntable looks at the steps themselves.
using Method = HybridResult (*)(const Recording&, const std::vector<Range>& rests, const Session&, const HybridOptions&);
HybridResult alone(Calibration calibration) { return {std::move(calibration), {}, {}, {}, 0}; }
const std::map<std::string, Method> methods{
    {"handheld", [](const Recording& recording, const std::vector<Range>& rests, const Session& session,
                    const HybridOptions& options) { return alone(calibrate_handheld(recording, rests, session.imu, session.site, options)); }},
    {"hybrid", calibrate_hybrid},
    {"static", [](const Recording& recording, const std::vector<Range>& rests, const Session& session,
                  const HybridOptions& options) { return alone(calibrate_static(recording, rests, session.imu, session.site, options)); }},
    {"turntable", [](const Recording& recording, const std::vector<Range>&, const Session& session, const HybridOptions& options) {
       return alone(calibrate_turntable(recording, session, TurntableOptions{options}));
     }}};

std::string utc_now() {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", std::gmtime(&now));
  return text;
}

/// "auto" and "full" are empty; else selectors separated by commas.
std::vector<int> parse_terms(const std::string& terms) {
  std::vector<int> indices;
  if (terms == "auto" || terms == "full") return indices;
  for (std::size_t begin = 0; begin <= terms.size();) {
    const std::size_t end = std::min(terms.find(',', begin), terms.size());
    try {
      for (const int index : select_coefficients(terms.substr(begin, end - begin))) indices.push_back(index);
    } catch (const Error& e) {
      throw Error(fmt::format("--terms: {}", e.what()));
    }
    begin = end + 1;
  }
  return indices;
}

/// A result with what was met before the estimate.
struct Outcome {
  HybridResult result;
  std::vector<std::string> warnings, notes;
};

Outcome with_one_recording(const CalibrateArguments& arguments, const Session& session) {
  HybridOptions options;
  options.terms = parse_terms(arguments.terms);
  if (arguments.terms == "full") throw Error("--terms full: only the method whole-unit takes it");
  const RecordingSource& source = choose_recording(session, arguments.recording);
  const RecordingReading reading = read_recording(session, source);
  for (const std::string& text : reading.warnings) warn(text);
  const Rests rests = rests_of(reading.recording, session);
  constexpr double points = 500;  // of a curve: as fine as a screen shows
  if (!arguments.curves.empty()) options.curve_interval = static_cast<double>(reading.recording.size()) * reading.recording.interval_s / points;
  return {methods.at(arguments.method)(reading.recording, rests.ranges, session, options), reading.warnings, rests.notes};
}

Outcome whole_unit(const CalibrateArguments& arguments, Session session) {
  WholeUnitOptions options;
  options.terms = parse_terms(arguments.terms);
  options.full = arguments.terms == "full";
  options.stepwise = arguments.stepwise;
  if (!arguments.recording.empty()) session.recordings = {choose_recording(session, arguments.recording)};
  std::erase_if(session.steps, [&](const Step& step) {
    return std::none_of(session.recordings.begin(), session.recordings.end(), [&](const RecordingSource& r) { return r.file == step.recording; });
  });
  Outcome outcome;
  std::vector<Recording> recordings;
  for (const RecordingSource& source : session.recordings) {
    RecordingReading reading = read_recording(session, source);
    for (const std::string& text : reading.warnings) warn(text);
    outcome.warnings.insert(outcome.warnings.end(), reading.warnings.begin(), reading.warnings.end());
    recordings.push_back(std::move(reading.recording));
  }
  outcome.result = alone(calibrate_whole_unit(recordings, session, options));
  return outcome;
}

}  // namespace

HybridResult calibrate(const CalibrateArguments& arguments) {
  if (arguments.stepwise && arguments.method != "whole-unit") throw Error("--stepwise: only the method whole-unit has steps");
  if (!arguments.curves.empty() && arguments.method != "hybrid") throw Error("--curves: only the method hybrid has convergence curves");
  const Session session = read_session(arguments.session);
  for (const std::string& output : {arguments.output, arguments.curves}) expect_inputs_stay(output, session);
  try {
    session.site.gravity();
  } catch (const Error& e) {  // neither g nor the latitude is known
    throw Error(fmt::format("{}: {}", session.file, e.what()));
  }
  Outcome outcome = arguments.method == "whole-unit" ? whole_unit(arguments, session) : with_one_recording(arguments, session);
  HybridResult& result = outcome.result;
  Calibration& calibration = result.calibration;
  calibration.created = utc_now();
  calibration.software = "imulab " IMULAB_VERSION;
  calibration.session_file = session.file;
  calibration.session_sha256 = session.sha256;
  Quality& quality = calibration.quality;
  quality.notes.insert(quality.notes.begin(), outcome.notes.begin(), outcome.notes.end());
  for (const std::string& text : quality.warnings) warn(text);
  quality.warnings.insert(quality.warnings.begin(), outcome.warnings.begin(), outcome.warnings.end());
  if (!arguments.output.empty()) {
    const std::string text = calibration_text(calibration);
    if (arguments.output == "-")
      fmt::print("{}", text);
    else
      write_whole(arguments.output, text);
  }
  if (!arguments.curves.empty()) write_whole(arguments.curves, curves_text(result));
  return std::move(outcome.result);
}

void add_calibrate(CLI::App& app) {
  const auto a = std::make_shared<CalibrateArguments>();
  CLI::App* const verb = app.add_subcommand("calibrate", "A session becomes a calibration with uncertainties");
  verb->add_option("session", a->session, "a session folder or its session.toml")->required();
  std::vector<std::string> names;
  for (const auto& [name, method] : methods) names.push_back(name);
  names.emplace_back("whole-unit");
  verb->add_option(
          "--method", a->method,
          "static: from rests alone; handheld: from rests and the rotations between them; turntable: from the table's angles; hybrid: from rests and "
          "turns in one place, without a table's angles; whole-unit: from chamber, rate table and centrifuge, all recordings together")
      ->required()
      ->check(CLI::IsMember(names));
  verb->add_option("-o,--output", a->output, "the calibration file to write; - for standard output");
  verb->add_option("--terms", a->terms,
                   "coefficients to estimate, for example accel.offset,gyro.matrix.diagonal; auto: what the data support; full (whole-unit): "
                   "all of it, significant or not")
      ->capture_default_str();
  verb->add_option("--recording", a->recording, "which recording, where the session has several");
  verb->add_flag("--stepwise", a->stepwise, "whole-unit: Dai's three steps one after the other in place of the joint estimate");
  verb->add_option("--curves", a->curves, "hybrid: a CSV file of how each coefficient's residual and its sigma converge");
  verb->add_flag("--json", a->json, "print the calibration file's text instead of the table");
  verb->callback([a] {
    const HybridResult result = calibrate(*a);
    const Calibration& calibration = result.calibration;
    if (a->json && a->output != "-") fmt::print("{}", calibration_text(calibration));
    if (!a->json && a->output != "-") print_calibration(calibration, a->method == "hybrid" ? &result.coarse : nullptr);
    if (!a->output.empty() && a->output != "-" && !a->json) fmt::print("\nwritten: {}\n", a->output);
    if (calibration.quality.unobservable.empty()) return;
    std::string list;
    for (const std::string& name : calibration.quality.unobservable) list += " " + name;
    throw Unsupported(fmt::format("the data do not determine:{}; they keep their starting values", list));
  });
}

}  // namespace imulab::command
