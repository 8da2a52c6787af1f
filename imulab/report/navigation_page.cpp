#include "imulab/report/navigation_page.hpp"

#include "imulab/core/units.hpp"
#include "imulab/report/html.hpp"
#include "imulab/report/page.hpp"
#include "imulab/report/pictures.hpp"
#include "imulab/report/start.hpp"
#include "imulab/report/track.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace imulab {

namespace report {
namespace {

std::string end_table(const NavigationErrors& errors) {
  const NavigationError& e = errors.history.back();
  const auto row = [](const std::string& name, const Eigen::Vector3d& v) {
    return std::vector<std::string>{name, number_text(v.x(), 4), number_text(v.y(), 4), number_text(v.z(), 4), number_text(v.head<2>().norm(), 4)};
  };
  Table t{.head = {"at " + stamp_and_date(e.time), "east", "north", "up", "horizontal"}, .rows = {}};
  t.rows = {row("position [m]", e.position), row("velocity [m/s]", e.velocity), row("attitude [arcsec]", e.attitude / unit::arcsec)};
  return table(t);
}

std::string alignment_text(const AlignedOn& aligned) {
  const EulerAngles angles = euler_angles(aligned.alignment.attitude.C_nb);
  const Eigen::Vector3d sigma = angle_sigmas(aligned.alignment.attitude) / unit::deg;
  return fmt::format("Aligned on the rest from {} to {}: roll {} ± {} deg, pitch {} ± {} deg, heading {} ± {} deg.", stamp_and_date(aligned.begin),
                     stamp_and_date(aligned.end), rounded_to(angles.roll / unit::deg, sigma.x()), uncertainty_text(sigma.x()),
                     rounded_to(angles.pitch / unit::deg, sigma.y()), uncertainty_text(sigma.y()), rounded_to(angles.heading / unit::deg, sigma.z()),
                     uncertainty_text(sigma.z()));
}

/// At most about a thousand of the errors.
ErrorBands bands_of(const NavigatedSession& s) {
  ErrorBands bands;
  bands.budget = s.explained ? &*s.explained : nullptr;
  bands.start = s.navigated.solution.time.front();
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

std::string session_sections(const NavigatedSession& s, bool only_one) {
  const Solution& solution = s.navigated.solution;
  std::string content = paragraph(fmt::format("Navigated from {} to {}, vertical channel {}. {}", stamp_and_date(solution.time.front()),
                                              stamp_and_date(solution.time.back()), to_string(s.navigated.vertical),
                                              s.navigated.aligned ? alignment_text(*s.navigated.aligned) : "Started as the session says."));
  if (s.errors) content += end_table(*s.errors);
  content += list(s.navigated.warnings);
  const std::string track = track_figure(thinned_track(s.navigated.track), "The solution.");
  const std::string bands = error_bands(bands_of(s));
  std::string out = section("session", only_one ? "Result" : s.session, "", content + beside({track}));
  if (!bands.empty())
    out += section("errors", "Errors over time",
                   s.explained
                       ? "The band is one sigma of what the calibration's uncertainties cause, and after an alignment also the noise that it saw; "
                         "how the IMU changed since is not in it."
                       : "",
                   bands);
  if (s.explained)
    out += section("shares", "Shares over time", "", shares_over_time(*s.explained, solution.time.front())) + sources_section(*s.explained);
  return out;
}

std::vector<double> rates_of(const NavigationSummary& sessions) {
  std::vector<double> rates;
  for (const NavigatedSession& s : sessions)
    if (s.errors) rates.push_back(s.errors->rate / unit::nmi_per_h);
  return rates;
}

Verdict navigation_verdict(const NavigationReport& report) {
  const std::vector<double> rates = rates_of(report.sessions);
  Verdict v{.tone = Tone::neutral, .word = "navigated", .meaning = "There is no reference, so errors are not known.", .because = {}, .actions = {}};
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
  page.title = r.sessions.size() == 1 ? r.sessions.front().session : fmt::format("{} sessions", r.sessions.size());
  page.subtitle = "Pure-inertial solution";
  page.verdict = navigation_verdict(r);
  std::vector<std::string> missing = r.missing;
  for (const NavigatedSession& session : r.sessions)
    if (!session.unexplained.empty()) missing.push_back(fmt::format("{}: the bands of the errors: {}", session.session, session.unexplained));
  if (!missing.empty()) page.body += section("missing", "Not on this page", "", list(missing, "missing-list"));
  for (const NavigatedSession& session : r.sessions) page.body += session_sections(session, r.sessions.size() == 1);
  return page_text(page);
}

namespace report {
namespace {

/// Fixed error and one sigma together, horizontally.
double horizontal(const Contribution& c, Eigen::Index at) {
  return std::sqrt(c.fixed.col(at).head<2>().squaredNorm() + c.sigma.col(at).head<2>().squaredNorm());
}

double horizontal_total(const ErrorBudget& b) {
  const auto end = static_cast<Eigen::Index>(b.time.size()) - 1;
  return std::sqrt(b.mean.col(end).head<2>().squaredNorm() + b.covariance.back()(0, 0) + b.covariance.back()(1, 1));
}

constexpr double negligible = 1e-6;  // beside the largest

/// A row for each contribution that counts, the largest horizontal position error first.
std::vector<std::vector<std::string>> contribution_rows(const std::vector<Contribution>& all, std::size_t most) {
  if (all.empty()) return {};
  const Eigen::Index end = all.front().sigma.cols() - 1;
  std::vector<std::size_t> order(all.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) { return horizontal(all[i], end) > horizontal(all[j], end); });
  std::vector<std::vector<std::string>> rows;
  for (std::size_t k = 0; k < std::min(most, order.size()); ++k) {
    const Contribution& c = all[order[k]];
    if (horizontal(c, end) < negligible * horizontal(all[order[0]], end)) break;
    std::vector<std::string> row{escaped(c.name), number_text(horizontal(c, end))};
    for (Eigen::Index q = 0; q < budget_quantities; ++q)
      row.push_back(number_text(std::hypot(c.fixed(q, end), c.sigma(q, end)) / error_quantities()[static_cast<std::size_t>(q)].size));
    rows.push_back(std::move(row));
  }
  return rows;
}

const std::vector<std::string> heads{"source", "horizontal [m]", "pos. east [m]", "north", "up", "vel. east [m/s]", "north",
                                     "up",     "att. east [″]",  "north",         "up"};

std::string share_figure(const ErrorBudget& b) {
  if (b.groups.empty()) return {};
  const Eigen::MatrixXd shares = horizontal_shares(b);
  const Eigen::Index end = shares.rows() - 1;
  std::vector<Interval> rows;
  for (Eigen::Index k = 0; k < shares.cols(); ++k) {
    const auto group = static_cast<std::size_t>(k);
    const double percent = 100 * shares(end, k);
    if (std::abs(percent) < 0.05) continue;
    rows.push_back({group < b.groups.size() ? b.groups[group].name : "correlation", percent, 0, fmt::format("{:.1f} %", percent), percent < 0});
  }
  std::sort(rows.begin(), rows.end(), [](const Interval& i, const Interval& j) { return i.value > j.value; });
  return figure(interval_rows(rows, "% of the mean square", "shares at the end"),
                "Shares of the mean square horizontal position error at the end. A source that partly cancels others has a negative share.");
}

std::string monte_carlo_text(const ErrorDistribution& d, std::uint64_t runs) {
  return fmt::format("Monte Carlo of {} runs: horizontal rate {} nmi/h RMS, {} nmi/h in half of the runs, {} nmi/h in 95 %.", runs,
                     number_text(d.drift_rms / unit::nmi_per_h), number_text(d.drift_cep / unit::nmi_per_h),
                     number_text(d.drift_95 / unit::nmi_per_h));
}

Verdict budget_verdict(const BudgetReport& r) {
  const ErrorBudget& b = r.summary.budget;
  Verdict v{
      .tone = Tone::neutral,
      .word = fmt::format("{} m after {} min", number_text(horizontal_total(b)), number_text(b.time.back() / 60)),
      .meaning = fmt::format("Horizontal position error: fixed errors and one sigma of drawn ones, vertical channel {}.", to_string(b.vertical)),
      .because = {},
      .actions = {}};
  if (r.summary.monte_carlo) v.because.push_back(monte_carlo_text(*r.summary.monte_carlo, r.summary.runs));
  const Eigen::VectorXd shares = horizontal_shares(b).bottomRows(1).transpose();
  Eigen::Index worst = 0;
  if (!b.groups.empty() && shares.head(static_cast<Eigen::Index>(b.groups.size())).maxCoeff(&worst) > 0)
    v.actions.push_back(
        fmt::format("Improve {} first: it has {:.0f} % of the mean square.", b.groups[static_cast<std::size_t>(worst)].name, 100 * shares[worst]));
  return v;
}

}  // namespace

std::string sources_section(const ErrorBudget& b) {
  Table sources{.head = heads, .rows = contribution_rows(b.groups, 100)}, coefficients{.head = heads, .rows = contribution_rows(b.coefficients, 15)};
  std::string content = share_figure(b) + table(sources);
  if (!coefficients.rows.empty()) content += "<h3>The coefficients with the largest effect</h3>\n" + table(coefficients);
  return section("sources", "Sources at the end", "Each source alone: fixed error and one sigma together.", content);
}

}  // namespace report

std::string budget_page(const BudgetReport& r) {
  using namespace report;
  const ErrorBudget& b = r.summary.budget;
  const ErrorDistribution* sampled = r.summary.monte_carlo ? &*r.summary.monte_carlo : nullptr;
  Page page;
  page.kind = "Error budget";
  page.title = r.mission;
  page.subtitle = fmt::format("{} min, vertical channel {}", number_text(b.time.back() / 60), to_string(b.vertical));
  page.verdict = budget_verdict(r);
  if (!r.missing.empty()) page.body += section("missing", "Not on this page", "", list(r.missing, "missing-list"));
  const std::string bands = error_bands({.budget = &b, .monte_carlo = sampled, .error_time = {}, .errors = {}}), shares = shares_over_time(b);
  page.body += bands.empty() ? "" : section("errors", "Errors over time", "", bands);
  page.body += shares.empty() ? "" : section("shares", "Shares over time", "", shares);
  page.body += sources_section(b);
  page.body += r.summary.track.size() < 2 ? "" : section("track", "Track", "", beside({track_figure(r.summary.track, "The motion.")}));
  return page_text(page);
}

}  // namespace imulab
