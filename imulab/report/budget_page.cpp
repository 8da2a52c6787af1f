#include "imulab/report/html.hpp"
#include "imulab/report/navigation_page.hpp"
#include "imulab/report/page.hpp"
#include "imulab/report/pictures.hpp"
#include "imulab/report/plot.hpp"
#include "imulab/report/track.hpp"
#include "imulab/results/aid_loss.hpp"
#include "imulab/results/budget.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace imulab {

namespace report {
namespace {

constexpr double negligible = 1e-6;  // beside the largest

/// A row for each contribution that counts, the largest horizontal position error first.
std::vector<std::vector<std::string>> contribution_rows(const std::vector<Contribution>& all, std::size_t most, const LengthUnit& length) {
  if (all.empty()) return {};
  const Eigen::Index end = all.front().sigma.cols() - 1;
  std::vector<std::size_t> order(all.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) { return horizontal_rms(all[i], end) > horizontal_rms(all[j], end); });
  std::vector<std::vector<std::string>> rows;
  for (std::size_t k = 0; k < std::min(most, order.size()); ++k) {
    const Contribution& c = all[order[k]];
    if (horizontal_rms(c, end) < negligible * horizontal_rms(all[order[0]], end)) break;
    std::vector<std::string> row{escaped(c.name), number_text(horizontal_rms(c, end) / length.size)};
    for (Eigen::Index q = 0; q < budget_quantities; ++q)
      row.push_back(
          number_text(std::hypot(c.fixed(q, end), c.sigma(q, end)) / (q < 3 ? length.size : error_quantities()[static_cast<std::size_t>(q)].size)));
    rows.push_back(std::move(row));
  }
  return rows;
}

std::vector<std::string> heads(const LengthUnit& length) {
  return {"source",
          fmt::format("horizontal [{}]", length.name),
          fmt::format("pos. east [{}]", length.name),
          "north",
          "up",
          "vel. east [m/s]",
          "north",
          "up",
          "att. east [″]",
          "north",
          "up"};
}

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

constexpr const char* sampled_text = "Shaded: from 5 to 95 % of the Monte Carlo's runs. ";
constexpr const char* linear_text = "Linear: fixed errors and one sigma of drawn ones.";
constexpr const char* rough_text = "Linear: fixed errors and one sigma of drawn ones, drawn as far as it is on the Monte Carlo's scale.";

/// "How long may it be away": figures over the time since the loss, each with its limit and where it is crossed.
std::string loss_section(const BudgetReport& r) {
  const ErrorBudget& b = r.summary.budget;
  if (!b.loss || r.curves.empty()) return "";
  std::vector<double> x, y;
  for (const LossCurve& c : r.curves) {
    for (std::size_t i = 0; i < c.seconds.size(); ++i)
      if (c.seconds[i] > 1.5) x.push_back(c.seconds[i]), y.push_back(c.meters[i]);
    if (c.limit) y.push_back(*c.limit);
  }
  const std::string aids = lost_aids(*b.loss);
  Plot plot(axis_over("s since the loss of " + aids, x, true), axis_over("m", y, true), "errors over the time since the loss", {960, 330});
  std::vector<std::pair<std::string, std::string_view>> entries;
  std::vector<std::string> lines;
  for (std::size_t k = 0; k < r.curves.size(); ++k) {
    const LossCurve& c = r.curves[k];
    plot.line(c.seconds, c.meters, color::series(k), 2), entries.emplace_back(c.name, color::series(k));
    if (!c.limit) continue;
    plot.rule(*c.limit, color::series(k));
    if (c.within && *c.within >= 1) plot.dots({*c.within}, {*c.limit}, color::series(k));
    lines.push_back(c.name + ": " +
                    (c.within ? fmt::format("for {} s after the loss", number_text(*c.within)) : std::string("as long as the loss lasts")));
  }
  const std::vector<ErrorsAfterLoss> after = errors_after_loss(b);
  Table t{.head = {"seconds after the loss", "horizontal [m]", "vertical [m]", "velocity [m/s]", "heading [deg]"}, .rows = {}};
  for (const ErrorsAfterLoss& e : after)
    t.rows.push_back(
        {number_text(e.seconds), number_text(e.horizontal), number_text(e.vertical), number_text(e.velocity), number_text(e.heading / unit::deg)});
  return section("loss", "How long may " + aids + " be away?", "",
                 list(lines) + key(entries) + figure(plot.svg(), "One sigma; dashed: the limits.", true) + table(t));
}

PageVerdict budget_verdict(const BudgetReport& r) {
  const ErrorBudget& b = r.summary.budget;
  const bool rough = large_angles(b).has_value(), sampled = r.summary.monte_carlo && r.summary.monte_carlo->mean.cols() > 0;
  PageVerdict v{.tone = Tone::neutral,
                .word = fmt::format("{}{} after {} min", rough && !sampled ? "roughly " : "",
                                    length_text(rough && sampled ? horizontal_rms(*r.summary.monte_carlo) : horizontal_rms(b, b.time.size() - 1)),
                                    number_text(b.time.back() / 60)),
                .meaning = fmt::format("Horizontal position error, {}, vertical channel {}.",
                                       rough && sampled ? fmt::format("root mean square of {} Monte Carlo runs", r.summary.runs)
                                                        : "fixed errors and one sigma of drawn ones",
                                       to_string(b.vertical)),
                .because = {},
                .actions = {}};
  if (b.loss) {
    const std::vector<ErrorsAfterLoss> after = errors_after_loss(b);
    v.word = fmt::format("{} after {} s", length_text(after.back().horizontal), number_text(after.back().seconds));
    v.meaning = fmt::format("Horizontal position error since the loss of {}, one sigma; {} with it.", lost_aids(*b.loss),
                            length_text(after.front().horizontal));
  }
  if (rough && !sampled && !b.loss)
    v.actions.emplace_back("Run the Monte Carlo, which holds for large errors too: imulab budget MISSION --runs 1000");
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
  const LengthUnit length = length_unit(horizontal_rms(b, b.time.size() - 1));
  Table sources{.head = heads(length), .rows = contribution_rows(b.groups, 100, length)},
      coefficients{.head = heads(length), .rows = contribution_rows(b.coefficients, 15, length)};
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
  page.title = name_of_file(r.mission);
  page.subtitle = b.loss ? fmt::format("Aided until {} s, then {} s without {}", number_text(b.loss->begin),
                                       number_text(b.time.back() - b.loss->begin), lost_aids(*b.loss))
                         : fmt::format("{} min, vertical channel {}", number_text(b.time.back() / 60), to_string(b.vertical));
  page.verdict = budget_verdict(r);
  take_conclusion(page.verdict, r.conclusion);
  if (!r.missing.empty()) page.body += section("missing", "Not on this page", "", list(r.missing, "missing-list"));
  const auto rough = large_angles(b);
  std::vector<std::string> warnings = r.warnings;
  if (rough && std::find(warnings.begin(), warnings.end(), *rough) == warnings.end()) warnings.push_back(*rough);  // of a saved budget
  if (!warnings.empty()) page.body += section("warnings", "Warnings", "", list(warnings));
  const ErrorBands bands{.budget = &b, .monte_carlo = sampled, .error_time = {}, .errors = {}, .rough = rough.has_value()};
  const std::string large = horizontal_picture(bands), small = error_bands(bands), shares = shares_over_time(b);
  if (!large.empty())
    page.body += section("horizontal", "Horizontal error", "",
                         figure(large, (sampled != nullptr ? sampled_text : "") + std::string(rough ? rough_text : linear_text), true));
  page.body += loss_section(r);
  page.body += sources_section(b);
  page.body += shares.empty() ? "" : section("shares", "Shares over time", "", shares);
  page.body += small.empty() ? "" : section("errors", "All errors over time", "", small);
  page.body += r.summary.track.size() < 2 ? "" : section("track", "Track", "", beside({track_figure(r.summary.track, "The motion.")}));
  return page_text(page);
}

}  // namespace imulab
