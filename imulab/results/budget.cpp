#include "imulab/results/budget.hpp"

#include "imulab/formats/text/figures.hpp"
#include "imulab/grade.hpp"
#include "imulab/model/published_grades.hpp"
#include "imulab/results/aid_loss.hpp"
#include "imulab/results/over_time.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <string_view>
#include <utility>

namespace imulab {
namespace {

using namespace result_io;

std::string header(std::string start, Eigen::Index quantities, std::initializer_list<std::string_view> columns) {
  for (Eigen::Index q = 0; q < quantities; ++q)
    for (const std::string_view column : columns) start += fmt::format(",{}_{}", quantity_names[static_cast<std::size_t>(q)], column);
  return start + "\n";
}

void add_row(std::string& text, const BudgetRows& fixed, const BudgetRows& sigma, Eigen::Index at) {
  for (Eigen::Index q = 0; q < budget_quantities; ++q)
    text += fmt::format(",{:.8g},{:.8g}", fixed(q, at) / quantity_size(q), sigma(q, at) / quantity_size(q));
  text += '\n';
}

std::string vertical_text(VerticalChannel vertical) {
  switch (vertical) {
    case VerticalChannel::free:
      return "vertical channel free";
    case VerticalChannel::fixed:
      return "height fixed";
    case VerticalChannel::aided:
      return "height aided by a barometer";
    case VerticalChannel::held:
      break;
  }
  return "height held by a barometer, vertical velocity free";
}

/// East, north and up of one quantity.
struct ErrorRows {
  const char* title;
  Eigen::Index first;  ///< of its rows
};
constexpr std::array<ErrorRows, 3> blocks{{{"position, m", 0}, {"velocity, m/s", 3}, {"attitude, arcsec", 6}}};

template <class Value>
std::string row_text(const ErrorRows& block, const Value& value) {
  std::string text;
  for (Eigen::Index q = block.first; q < block.first + 3; ++q) text += fmt::format(" {:>10}", text::number(value(q) / quantity_size(q)));
  return text;
}

constexpr std::size_t name_width = 26;

std::string line_text(std::string_view name, const char* what, const std::string& row) {
  return fmt::format("{:<{}} {:<5}{}\n", name, name_width, what, row);
}

std::string total_rows(const ErrorRows& block, const ErrorBudget& b) {
  const auto end = static_cast<Eigen::Index>(b.time.size()) - 1;
  return line_text("all together", "fixed", row_text(block, b.mean.col(end))) + line_text("", "sigma", row_text(block, total_sigma(b).col(end)));
}

std::vector<std::size_t> by_share(const std::vector<double>& shares, std::size_t groups) {
  std::vector<std::size_t> order(groups);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t x, std::size_t y) { return shares[x] > shares[y]; });
  return order;
}

std::string percent(double share) { return fmt::format("{:.1f} %", std::round(1000 * share) / 10 + 0.0); }

/// Sources by their share, the largest first.
std::string source_rows(const ErrorRows& block, const ErrorBudget& b) {
  const auto end = static_cast<Eigen::Index>(b.time.size()) - 1;
  const std::vector<double> shares = b.horizontal_shares(b.time.size() - 1);
  const bool shown = block.first == 0;  // shares are of the position
  std::string text;
  for (const std::size_t k : by_share(shares, b.groups.size())) {
    const Contribution& c = b.groups[k];
    const bool drawn = !c.sigma.col(end).isZero(0), fixed = !c.fixed.col(end).isZero(0);
    std::string share = shown ? fmt::format(" {:>9}", percent(shares[k])) : "";
    if (fixed || !drawn) text += line_text(c.name, "fixed", row_text(block, c.fixed.col(end)) + std::exchange(share, ""));
    if (drawn) text += line_text(fixed ? "" : c.name, "sigma", row_text(block, c.sigma.col(end)) + share);
  }
  if (shown && std::abs(shares.back()) > 5e-4) text += fmt::format("{:<65} {:>9}\n", "correlation between groups", percent(shares.back()));
  return text;
}

std::string block_text(const ErrorRows& block, const ErrorBudget& b) {
  std::string text = fmt::format("\n{:<32} {:>10} {:>10} {:>10}{}\n", block.title, "east", "north", "up", block.first == 0 ? "     share" : "");
  return text + source_rows(block, b) + total_rows(block, b);
}

/// Horizontal position, and what causes most of it.
std::string headline(const ErrorBudget& b, const std::optional<ErrorDistribution>& monte_carlo) {
  const std::vector<double> shares = b.horizontal_shares(b.time.size() - 1);
  std::string largest;
  for (const std::size_t k : by_share(shares, b.groups.size())) {
    if (shares[k] < 0.05 || std::count(largest.begin(), largest.end(), '%') == 3) break;
    largest += fmt::format("{}{} {:.0f} %", largest.empty() ? "" : ", ", b.groups[k].name, 100 * shares[k]);
  }
  return text::wrapped("", budget_headline(b, monte_carlo)) + (largest.empty() ? "" : text::wrapped("  most of it from: ", largest));
}

std::string monte_carlo_line(const ErrorDistribution& d) {
  const auto end = static_cast<Eigen::Index>(d.time.size()) - 1;
  return text::wrapped("  ",
                       fmt::format("Monte Carlo, {} runs: horizontal position median {:.4g} m, 5..95 % {:.4g}..{:.4g} m; pure-inertial rate {:.3g} "
                                   "nmi/h RMS, CEP {:.3g} nmi/h, 95 % {:.3g} nmi/h",
                                   d.runs, d.median(budget_quantities, end), d.low(budget_quantities, end), d.high(budget_quantities, end),
                                   d.drift_rms / unit::nmi_per_h, d.drift_cep / unit::nmi_per_h, d.drift_95 / unit::nmi_per_h));
}

std::string monte_carlo_rows(const ErrorRows& block, const ErrorDistribution& d) {
  const auto end = static_cast<Eigen::Index>(d.time.size()) - 1;
  return line_text("Monte Carlo", "mean", row_text(block, d.mean.col(end))) + line_text("", "sigma", row_text(block, d.sigma.col(end))) +
         line_text("", "5 %", row_text(block, d.low.col(end))) + line_text("", "50 %", row_text(block, d.median.col(end))) +
         line_text("", "95 %", row_text(block, d.high.col(end)));
}

}  // namespace

double horizontal_rms(const ErrorBudget& b, std::size_t at) {
  return std::sqrt(b.mean.col(static_cast<Eigen::Index>(at)).head<2>().squaredNorm() + b.covariance[at](0, 0) + b.covariance[at](1, 1));
}

double horizontal_rms(const Contribution& source, Eigen::Index at) {
  return std::hypot(source.fixed.col(at).head<2>().norm(), source.sigma.col(at).head<2>().norm());
}

double horizontal_rms(const ErrorDistribution& runs) {
  if (runs.mean.cols() == 0) return std::numeric_limits<double>::quiet_NaN();  // of a file without its history
  const Eigen::Index end = runs.mean.cols() - 1;
  return std::hypot(runs.mean(budget_quantities, end), runs.sigma(budget_quantities, end));
}

std::string budget_headline(const ErrorBudget& b, const std::optional<ErrorDistribution>& monte_carlo) {
  const bool rough = large_angles(b).has_value(), sampled = rough && monte_carlo;
  if (b.loss) {
    const std::vector<ErrorsAfterLoss> after = errors_after_loss(b);
    return fmt::format("{:.4g} s after the loss of {}: horizontal position error {}{} m RMS, {} m with it", after.back().seconds, lost_aids(*b.loss),
                       rough ? "roughly " : "", text::number(after.back().horizontal), text::number(after.front().horizontal));
  }
  return fmt::format("after {:g} s: horizontal position error {}{} m RMS{}, {}", b.time.back(), rough && !sampled ? "roughly " : "",
                     text::number(sampled ? horizontal_rms(*monte_carlo) : horizontal_rms(b, b.time.size() - 1)),
                     sampled ? " of the Monte Carlo" : "", vertical_text(b.vertical));
}

std::optional<std::string> large_angles(const ErrorBudget& b) {
  constexpr double largest = 0.1;
  for (std::size_t i = 0; i < b.time.size(); ++i) {
    if (b.loss && b.time[i] < b.loss->begin) continue;  // before it the filter's data take a large error away
    for (Eigen::Index q = 6; q < budget_quantities; ++q)
      if (std::hypot(b.mean(q, static_cast<Eigen::Index>(i)), std::sqrt(b.covariance[i](q, q))) > largest)
        return fmt::format("an attitude error exceeds {1:g} rad from {0:g} s on; the linear figures are rough{2}", b.time[i], largest,
                           b.loss ? "" : "; rely on the Monte Carlo");
  }
  return std::nullopt;
}

std::string total_csv(const ErrorBudget& b) {
  const BudgetRows sigma = total_sigma(b);
  std::string text = header("t", budget_quantities, {"fixed", "sigma"});
  for (std::size_t i = 0; i < b.time.size(); ++i) {
    text += fmt::format("{:.10g}", b.time[i]);
    add_row(text, b.mean, sigma, static_cast<Eigen::Index>(i));
  }
  return text;
}

std::string sources_csv(const ErrorBudget& b) {
  std::string text = header("source,t", budget_quantities, {"fixed", "sigma", "share"});
  for (std::size_t i = 0; i < b.time.size(); ++i) {
    std::array<std::vector<double>, budget_quantities> shares;
    for (int q = 0; q < budget_quantities; ++q) shares[static_cast<std::size_t>(q)] = b.shares(q, i);
    for (std::size_t k = 0; k <= b.groups.size(); ++k) {  // the last: the correlation
      const bool group = k < b.groups.size();
      text += fmt::format("{},{:.10g}", group ? b.groups[k].name : "correlation between groups", b.time[i]);
      for (Eigen::Index q = 0; q < budget_quantities; ++q) {
        const auto at = static_cast<Eigen::Index>(i);
        const double unit = quantity_size(q), fixed = group ? b.groups[k].fixed(q, at) / unit : 0,
                     sigma = group ? b.groups[k].sigma(q, at) / unit : 0;
        text += fmt::format(",{:.8g},{:.8g},{:.6g}", fixed, sigma, shares[static_cast<std::size_t>(q)][k]);
      }
      text += '\n';
    }
  }
  return text;
}

std::string runs_csv(const ErrorDistribution& d) {
  std::string text = header("run", budget_quantities, {"end", "peak"});
  for (Eigen::Index k = 0; k < d.end.cols(); ++k) {
    text += fmt::format("{}", k);
    add_row(text, d.end, d.peak, k);
  }
  return text;
}

std::string distribution_csv(const ErrorDistribution& d) {
  std::string text = header("t", budget_quantities + 1, {"low", "median", "high"});
  for (std::size_t i = 0; i < d.time.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    text += fmt::format("{:.10g}", d.time[i]);
    for (Eigen::Index q = 0; q <= budget_quantities; ++q)
      text +=
          fmt::format(",{:.8g},{:.8g},{:.8g}", d.low(q, at) / quantity_size(q), d.median(q, at) / quantity_size(q), d.high(q, at) / quantity_size(q));
    text += '\n';
  }
  return text;
}

std::string budget_table(const ErrorBudget& b, const std::optional<ErrorDistribution>& monte_carlo, bool details) {
  std::string text = headline(b, monte_carlo);
  if (b.loss) text += after_loss_table(b);
  if (monte_carlo) text.insert(large_angles(b) ? 0 : text.size(), monte_carlo_line(*monte_carlo));
  for (const ErrorRows& block : blocks) {
    if ((block.first > 0 || b.loss) && !details) break;
    text += block_text(block, b);
    if (monte_carlo && details) text += monte_carlo_rows(block, *monte_carlo);
  }
  return text;
}

namespace {

std::string range(const std::array<double, 2>& r, double unit) {
  return r[0] == 0 ? fmt::format("below {:g}", r[1] / unit) : fmt::format("{:g}..{:g}", r[0] / unit, r[1] / unit);
}

}  // namespace

namespace result_io {

std::vector<std::pair<std::string, NamedNumbers>> shares_at_end(const ErrorBudget& b) {
  std::vector<std::pair<std::string, NamedNumbers>> out;
  for (const Contribution& group : b.groups) out.emplace_back(group.name, NamedNumbers());
  out.emplace_back("correlation between groups", NamedNumbers());
  for (int q = 0; q < budget_quantities; ++q) {
    const std::vector<double> shares = b.shares(q, b.time.size() - 1);
    for (std::size_t k = 0; k < shares.size(); ++k) out[k].second.emplace_back(quantity_names[static_cast<std::size_t>(q)], shares[k]);
  }
  return out;
}

}  // namespace result_io

std::string grade_catalogue() {
  std::string text = "Grades as published (Xu 2024, table 1)\n\n";
  text += fmt::format("  {:<12} {:>12} {:>13} {:>10} {:>13} {:>10}\n", "", "rate nmi/h", "gyro deg/h", "accel ug", "misal. arcsec", "scale ppm");
  for (const PublishedGrade& g : published_grades())
    text += fmt::format(
        "  {:<12} {:>12} {:>13} {:>10} {:>13} {:>10}\n", g.name,
        g.position_rate[0] == 0 ? fmt::format("{:.0f} m/h", g.position_rate[1] * unit::hour) : range(g.position_rate, unit::nmi_per_h),
        range(g.gyro_bias, unit::deg_per_h), range(g.accel_bias, unit::ug), range(g.misalignment, unit::arcsec), range(g.scale, unit::ppm));
  text += fmt::format("\nAirliners' systems as published (Xu 2024, table 2)\n\n  {:<12} {:<9} {:>10} {:>11}  {}\n", "", "gyro", "rate nmi/h",
                      "gyro deg/h", "aircraft");
  for (const AirlinerSystem& s : airliner_systems())
    text += fmt::format("  {:<12} {:<9} {:>10.2g} {:>11.2g}  {}\n", s.name, s.gyro, s.position_rate / unit::nmi_per_h, s.gyro_bias / unit::deg_per_h,
                        s.aircraft);
  text += fmt::format(
      "\nGrades to draw from (one sigma of each coefficient)\n\n  {:<12} {:>10} {:>8} {:>8} {:>9} {:>11} {:>10}\n  {:<12} {:>10} {:>8} {:>8} {:>9} "
      "{:>11} {:>10}\n",
      "", "gyro", "accel", "misal.", "scale", "ARW", "VRW", "", "deg/h", "ug", "arcsec", "ppm", "deg/sqrt(h)", "ug/sqrt(Hz)");
  for (const Grade& g : grades())
    text += fmt::format("  {:<12} {:>10.3g} {:>8.3g} {:>8.3g} {:>9.3g} {:>11.3g} {:>10.3g}\n", g.name, g.gyro_bias / unit::deg_per_h,
                        g.accel_bias / unit::ug, g.gyro_misalignment / unit::arcsec, g.gyro_scale / unit::ppm, g.gyro_noise.N / unit::deg_per_sqrt_h,
                        g.accel_noise.N / unit::ug_per_sqrt_hz);
  return text;
}

}  // namespace imulab
