// imulab navigate CALIBRATION SESSION...
#include "imulab/tasks/navigate.hpp"

#include "apps/imulab/command.hpp"
#include "apps/imulab/files.hpp"
#include "apps/imulab/sessions.hpp"
#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/session/file.hpp"
#include "imulab/formats/solution/aided_solution.hpp"
#include "imulab/formats/solution/solution.hpp"
#include "imulab/formats/text/terminal.hpp"
#include "imulab/tasks/aided.hpp"
#include "imulab/tasks/navigation_figures.hpp"

#include <fmt/core.h>

#include <cstdint>
#include <optional>
#include <utility>

namespace imulab::command {

namespace {

/// The word none: an IMU whose recordings are in SI already.
UsableCalibration calibration_of(const std::string& name, bool allow_undetermined) {
  if (name == "none") return {no_calibration(), {}};
  UsableCalibration usable = read_usable(name, allow_undetermined);
  if (usable.calibration.estimated.empty() && usable.calibration.method != "truth") {
    usable.warnings.push_back(name + ": states no uncertainties; those of the solution take it as exact");
    warn(usable.warnings.back());
  }
  return usable;
}

void check_inertial(const NavigateVerbOptions& o) {
  if (o.require) errors_of_option("require", [&] { expect_navigation_limits(*o.require); });
  if (o.sessions.size() == 1) return;
  for (const auto& [name, value] : {std::pair("--output", o.output), std::pair("--truth", o.truth), std::pair("--barometer", o.barometer)})
    if (!value.empty()) throw Error(fmt::format("{}: belongs to one session; expected a single SESSION", name));
}

Session session_of_one(const std::string& name, const RecordingWords& words) {
  Session session = open_session(name, words);
  if (session.recordings.size() != 1) throw Error(fmt::format("{}: has {} recordings; expected one", session.file, session.recordings.size()));
  return session;
}

void run_aided(const NavigateVerbOptions& o, const UsableCalibration& usable) {
  const Session session = session_of_one(o.sessions.front(), {o.declarations, o.topics});
  Recording recording = read_for(usable.calibration, session, session.recordings[0]);
  std::optional<std::int64_t> gps_ahead;
  if (needs_dates(o.output)) {
    gps_ahead = gps_time_ahead(session, session.recordings[0], recording);
    errors_at("-o", [&] { expect_dates(o.output, gps_ahead); });
  }
  std::optional<Progress> progress(std::in_place, "navigating");
  std::optional<AidedSolutionFile> file;  // takes the states as they are reached
  AidedOptions options{.keep = false};
  if (!o.output.empty()) {
    file.emplace(o.output, gps_ahead);
    options.each = [&file](const AidedNavigation& n, double time, const NavigationState& state) { file->add(n, time, state); };
  }
  const AnswerOf<AidedNavigation> answer =
      aided_answer(o.sessions.front(), usable.calibration, session, std::move(recording), o, usable.warnings, std::move(options));
  if (file) file->commit();
  progress.reset();
  show(answer, o, file ? fmt::format("{}: {} states\n", o.output, answer.data->states) : "");
}

NavigatedSession navigated(const NavigateVerbOptions& o, const NavigateOptions& options, const Calibration& calibration, const std::string& name,
                           const Session& session) {
  if (o.require && o.truth.empty() && !session.truth_file)
    throw OptionError("require", name + ": has no truth; expected [truth] in the session, or --truth FILE: without one errors are not known");
  Recording recording = read_for(calibration, session, session.recordings[0]);
  const std::optional<TrueMotion> truth = o.truth.empty() ? session_truth(session) : read_truth(o.truth);
  const Progress progress("navigating");
  return navigate_session(name, calibration, session, std::move(recording), options, truth, !o.report.empty() || o.json);
}

void run(const NavigateVerbOptions& o) {
  check_aided(o), check_inertial(o);
  if (o.aided && o.output == "-") throw OptionError("output", "with --aided expected a file");
  errors_of_option("output", [&] { expect_solution_ending(o.output, o.aided); });
  if (o.json && o.output == "-") throw Error("--json: standard output has the solution; expected -o FILE");
  const auto [calibration, warnings] = calibration_of(o.calibration, o.allow_undetermined);
  if (o.aided) return run_aided(o, {calibration, warnings});
  std::vector<Session> opened;  // all of them before the first is navigated
  std::vector<NavigateOptions> options;
  for (const std::string& name : o.sessions) {
    opened.push_back(session_of_one(name, {o.declarations, o.topics}));
    options.push_back(navigate_options(o, opened.back()));
    options.back().keep = false;
  }
  std::optional<SolutionFile> file;  // takes the states as they are reached
  if (!o.output.empty()) {
    file.emplace(o.output);
    options.front().each = [&file](double time, const NavigationState& state) { file->add(time, state); };
  }
  std::vector<NavigatedSession> sessions;
  for (std::size_t i = 0; i < opened.size(); ++i) sessions.push_back(navigated(o, options[i], calibration, o.sessions[i], opened[i]));
  if (file) file->commit();
  show(navigation_answer(std::move(sessions), o, warnings), o, file ? fmt::format("{}: {} states\n", o.output, file->states()) : "");
}

}  // namespace

void add_navigate(Verb& app) { add<NavigateVerbOptions>(app, run); }

}  // namespace imulab::command
