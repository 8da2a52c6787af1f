// imulab navigate CALIBRATION SESSION...
#include "imulab/navigation/navigate.hpp"

#include "apps/imulab/command.hpp"
#include "apps/imulab/files.hpp"
#include "apps/imulab/report.hpp"
#include "apps/imulab/session_recording.hpp"
#include "apps/imulab/usable.hpp"
#include "imulab/core/error.hpp"
#include "imulab/core/units.hpp"
#include "imulab/formats/recording/solution.hpp"
#include "imulab/formats/session/file.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/terminal.hpp"
#include "imulab/report/navigation_page.hpp"
#include "imulab/tasks/navigate.hpp"

#include <fmt/core.h>

#include <filesystem>
#include <map>
#include <memory>

namespace imulab::command {

namespace {

namespace fs = std::filesystem;

struct Options {
  std::string calibration, output, report, truth, barometer, vertical = "free", gaps = "integrate";
  std::vector<std::string> sessions;
  std::optional<double> heading_deg, heading_sigma_deg;
  NavigateOptions navigate;
  bool json = false, allow_undetermined = false;
};

const std::map<std::string, VerticalChannel> vertical_channels{
    {"free", VerticalChannel::free}, {"fixed", VerticalChannel::fixed}, {"aided", VerticalChannel::aided}, {"held", VerticalChannel::held}};

/// The word none: an IMU whose recordings are in SI already.
Calibration calibration_of(const std::string& name, bool allow_undetermined) {
  if (name != "none") {
    Calibration calibration = read_usable(name, allow_undetermined);
    if (calibration.estimated.empty() && calibration.method != "truth")
      warn(name + ": states no uncertainties; those of the solution take it as exact");
    return calibration;
  }
  return no_calibration();
}

void check(const Options& o) {
  const bool needs_heights = o.navigate.vertical == VerticalChannel::aided || o.navigate.vertical == VerticalChannel::held;
  if (!o.barometer.empty() && !needs_heights) throw Error("--barometer: belongs to --vertical aided or held; expected one of them");
  if (o.heading_sigma_deg && !o.heading_deg) throw Error("--heading-sigma: belongs to --heading; expected both");
  if (o.sessions.size() == 1) return;
  for (const auto& [name, value] : {std::pair("--output", o.output), std::pair("--truth", o.truth), std::pair("--barometer", o.barometer)})
    if (!value.empty()) throw Error(fmt::format("{}: belongs to one session; expected a single SESSION", name));
}

Session session_of_one(const std::string& name) {
  Session session = session_at(name);
  if (session.recordings.size() != 1) throw Error(fmt::format("{}: has {} recordings; expected one", session.file, session.recordings.size()));
  return session;
}

NavigatedSession navigated(const Options& options, const Calibration& calibration, const std::string& name, const Session& session) {
  Recording recording = read_for(calibration, session, session.recordings[0]);
  const std::optional<TrueMotion> truth = options.truth.empty() ? session_truth(session) : read_truth(options.truth);
  const NavigatedSession out = [&] {
    const Progress progress("navigating");
    return navigate_session(name, calibration, session, std::move(recording), options.navigate, truth, !options.report.empty() || options.json);
  }();
  const std::string who = options.sessions.size() > 1 ? name + ": " : "";
  for (const auto& text : out.navigated.warnings) warn(who + text);
  if (out.errors)
    for (const auto& text : out.errors->warnings) warn(who + text);
  return out;
}

void run(Options options) {
  options.navigate.vertical = vertical_channels.at(options.vertical);
  options.navigate.gaps = options.gaps == "refuse" ? GapTreatment::refuse : GapTreatment::integrate;
  check(options);
  if (options.json && options.output == "-") throw Error("--json: standard output has the solution; expected -o FILE");
  const Calibration calibration = calibration_of(options.calibration, options.allow_undetermined);
  if (!options.barometer.empty()) options.navigate.barometer = read_heights(options.barometer);
  if (options.heading_deg) options.navigate.heading = {*options.heading_deg * unit::deg, options.heading_sigma_deg.value_or(0) * unit::deg};
  std::vector<Session> opened;  // all of them before the first is navigated
  for (const auto& name : options.sessions) opened.push_back(session_of_one(name));
  std::optional<SolutionFile> file;  // takes the states as they are reached
  options.navigate.keep = false;
  if (!options.output.empty()) {
    file.emplace(options.output);
    options.navigate.each = [&file](double time, const NavigationState& state) { file->add(time, state); };
  }
  std::vector<NavigatedSession> sessions;
  for (std::size_t i = 0; i < opened.size(); ++i) sessions.push_back(navigated(options, calibration, options.sessions[i], opened[i]));
  if (file) file->commit();
  if (!options.report.empty()) write_whole(options.report, navigation_page({.sessions = sessions}));
  if (options.output == "-") return;
  options.json ? print_json(navigation_json(sessions)) : print(navigation_table(sessions));
  if (options.output.empty() || options.json) return;
  print(fmt::format("{}: {} states\n", options.output, file->states()));
}

}  // namespace

void add_navigate(Verb app) {
  const auto o = std::make_shared<Options>();
  Verb verb = app.verb("navigate", "Align, compute the pure-inertial solution, and compare it with a truth");
  verb.option("CALIBRATION", o->calibration, "calibration.json, or none if the recordings are in rad/s and m/s^2 already").required().reads();
  verb.option("SESSION", o->sessions, "session folders or session.toml files, each with one recording; several give one row each")
      .required()
      .takes_several(1)
      .reads();
  verb.option("--vertical CHANNEL", o->vertical, "treatment of the vertical channel; aided and held need --barometer")
      .one_of({"free", "fixed", "aided", "held"})
      .show_default();
  verb.option("--barometer FILE", o->barometer, "heights for aided and held: a CSV file with t,height_m").reads();
  verb.flag("--align", o->navigate.align, "align on the first rest even if the session gives an attitude");
  verb.option("--heading", o->heading_deg, "heading at the end of the rest, deg; only roll and pitch are then aligned").in_range(-360., 360.);
  verb.option("--heading-sigma", o->heading_sigma_deg, "standard uncertainty of --heading, deg; exact if absent").in_range(0., 180.);
  verb.option("--gaps HOW", o->gaps, "what to do at missing samples").one_of({"integrate", "refuse"}).show_default();
  verb.option("--truth FILE", o->truth, "reference solution; the session's [truth] if absent").reads();
  verb.option("-o,--output FILE", o->output, "write the whole solution to this CSV file; - for standard output in place of the table").writes();
  add_report_option(verb, o->report);
  add_allow_undetermined(verb, o->allow_undetermined);
  verb.flag("--json", o->json, "print the result as JSON");
  verb.example("imulab navigate calibration.json drive --vertical fixed -o solution.csv");
  verb.does([o] { run(*o); });
}

}  // namespace imulab::command
