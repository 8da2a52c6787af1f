#include "imulab/report/budget_page.hpp"

#include "imulab/core/units.hpp"
#include "imulab/report/html.hpp"
#include "imulab/report/page.hpp"
#include "imulab/report/pictures.hpp"
#include "imulab/report/track.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace imulab {

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
