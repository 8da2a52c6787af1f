#include "imulab/report/navigation_page.hpp"

#include "imulab/navigation/navigation_error.hpp"
#include "imulab/report/html.hpp"
#include "imulab/report/page.hpp"
#include "imulab/report/pictures.hpp"
#include "imulab/report/start.hpp"
#include "imulab/report/track.hpp"
#include "imulab/results/budget.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace imulab {

namespace report {
namespace {

/// `start` [s] of the session, from which readers count.
std::string end_table(const NavigationErrors& errors, double start) {
  const NavigationError& e = errors.history.back();
  const LengthUnit length = length_unit(e.position.cwiseAbs().maxCoeff());
  const auto row = [](const std::string& name, const Eigen::Vector3d& v) {
    return std::vector<std::string>{name, number_text(v.x(), 4), number_text(v.y(), 4), number_text(v.z(), 4), number_text(v.head<2>().norm(), 4)};
  };
  Table t{.head = {"error after " + seconds_text(e.time - start), "east", "north", "up", "horizontal"}, .rows = {}};
  t.rows = {row(fmt::format("position [{}]", length.name), e.position / length.size), row("velocity [m/s]", e.velocity),
            row("attitude [arcsec]", e.attitude / unit::arcsec)};
  return table(t);
}

std::string alignment_text(const AlignedOn& aligned) {
  const EulerAngles angles = euler_angles(aligned.alignment.attitude.C_nb);
  const Eigen::Vector3d sigma = angle_sigmas(aligned.alignment.attitude) / unit::deg;
  return fmt::format("Aligned on a rest of {}: roll {} deg (u = {}), pitch {} deg (u = {}), heading {} deg (u = {}).",
                     seconds_text(aligned.end - aligned.begin), rounded_to(angles.roll / unit::deg, sigma.x()), uncertainty_text(sigma.x()),
                     rounded_to(angles.pitch / unit::deg, sigma.y()), uncertainty_text(sigma.y()), rounded_to(angles.heading / unit::deg, sigma.z()),
                     uncertainty_text(sigma.z()));
}

/// At most about a thousand of the errors.
ErrorBands bands_of(const NavigatedSession& s) {
  ErrorBands bands;
  bands.budget = s.explained ? &*s.explained : nullptr;
  bands.start = s.navigated.solution.time.front();
  bands.rough = s.explained && large_angles(*s.explained);
  if (!s.errors || s.errors->history.size() < 2) return bands;
  const auto& history = s.errors->history;
  const std::size_t step = std::max<std::size_t>(1, history.size() / 500);
  for (std::size_t i = 0; i < history.size(); i += step) bands.error_time.push_back(history[i].time);
  bands.errors.resize(budget_quantities, static_cast<Eigen::Index>(bands.error_time.size()));
  for (std::size_t k = 0; k < bands.error_time.size(); ++k) {
    const NavigationError& e = history[k * step];
    bands.errors.col(static_cast<Eigen::Index>(k)) << e.position, e.velocity, e.attitude;
  }
  return bands;
}

/// The caption.
std::string bands_text(const NavigatedSession& s) {
  if (!s.explained) return "";
  return std::string(s.errors ? "Expected" : "Root of the mean square") +
         ": what the calibration's uncertainties cause, and after an alignment also the noise that it saw; how the IMU changed since is not in it.";
}

/// Those of the solution and of its comparison.
std::vector<std::string> warnings_of(const NavigationReport& report) {
  std::vector<std::string> out = report.warnings;
  for (const NavigatedSession& s : report.sessions) {
    std::vector<std::string> all = s.navigated.warnings;
    if (s.errors) all.insert(all.end(), s.errors->warnings.begin(), s.errors->warnings.end());
    if (s.explained)
      if (const auto rough = large_angles(*s.explained)) all.push_back(*rough);
    for (const std::string& text : all)
      if (std::string named = (report.sessions.size() > 1 ? s.session + ": " : "") + text; std::ranges::find(out, named) == out.end())
        out.push_back(std::move(named));  // those of a saved answer have those of its sessions
  }
  return out;
}

std::string session_sections(const NavigatedSession& s, bool only_one) {
  const Solution& solution = s.navigated.solution;
  const double start = solution.time.front();
  std::string content = paragraph(fmt::format("Navigated {} from {}, vertical channel {}. {}", seconds_text(solution.time.back() - start),
                                              stamp_and_date(start), to_string(s.navigated.vertical),
                                              s.navigated.aligned ? alignment_text(*s.navigated.aligned) : "Started as the session says."));
  if (s.errors) content += end_table(*s.errors, start);
  const ErrorBands bands = bands_of(s);
  const std::string of = only_one ? "" : s.session + ": ", large = horizontal_picture(bands), small = error_bands(bands);
  std::string out;
  if (!large.empty()) out += section("horizontal", of + "Horizontal error", "", figure(large, bands_text(s), true));
  out += section("session", of + "Result", "", content + beside({track_figure(thinned_track(s.navigated.track), "The solution.")}));
  if (!small.empty()) out += section("errors", of + "Errors over time", "", small);
  if (s.explained)
    out += section("shares", of + "Shares over time", "", shares_over_time(*s.explained, solution.time.front())) + sources_section(*s.explained);
  return out;
}

std::vector<double> rates_of(const NavigationSummary& sessions) {
  std::vector<double> rates;
  for (const NavigatedSession& s : sessions)
    if (s.errors) rates.push_back(s.errors->rate / unit::nmi_per_h);
  return rates;
}

PageVerdict navigation_verdict(const NavigationReport& report) {
  const std::vector<double> rates = rates_of(report.sessions);
  PageVerdict v{
      .tone = Tone::neutral, .word = "navigated", .meaning = "There is no reference, so errors are not known.", .because = {}, .actions = {}};
  if (!rates.empty()) {
    const RateSummary summary = rate_summary(rates);
    v.word = fmt::format("{} nmi/h", number_text(summary.rms));
    v.meaning = rates.size() == 1
                    ? "Horizontal position error at the end over the time navigated."
                    : fmt::format("Root mean square of {} pure-inertial rates; half stay below {} nmi/h.", rates.size(), number_text(summary.cep));
  }
  for (const NavigatedSession& s : report.sessions) {
    const std::string who = report.sessions.size() > 1 ? s.session + ": " : "";
    if (!s.navigated.gaps.empty()) v.because.push_back(fmt::format("{}{} gaps were bridged", who, s.navigated.gaps.size()));
    if (s.navigated.saturated > 0) v.because.push_back(fmt::format("{}{} samples at a limit were integrated", who, s.navigated.saturated));
  }
  return v;
}

}  // namespace
}  // namespace report

std::string navigation_page(const NavigationReport& r) {
  using namespace report;
  Page page;
  page.kind = "Navigation";
  page.title = r.sessions.size() == 1 ? name_of_file(r.sessions.front().session) : fmt::format("{} sessions", r.sessions.size());
  page.subtitle = "Pure-inertial solution";
  page.verdict = navigation_verdict(r);
  take_conclusion(page.verdict, r.conclusion);
  std::vector<std::string> missing = r.missing;
  for (const NavigatedSession& session : r.sessions)
    if (!session.unexplained.empty()) missing.push_back(fmt::format("{}: the bands of the errors: {}", session.session, session.unexplained));
  if (!missing.empty()) page.body += section("missing", "Not on this page", "", list(missing, "missing-list"));
  const std::vector<std::string> warnings = warnings_of(r);
  for (const NavigatedSession& session : r.sessions) page.body += session_sections(session, r.sessions.size() == 1);
  if (!warnings.empty()) page.body = section("warnings", "Warnings", "", list(warnings)) + page.body;
  return page_text(page);
}

}  // namespace imulab
