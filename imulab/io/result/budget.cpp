#include "imulab/io/result/budget.hpp"

#include "imulab/core/units.hpp"
#include "imulab/io/result/budget_quantities.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
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
  for (Eigen::Index q = 0; q < budget_quantities; ++q) text += fmt::format(",{:.8g},{:.8g}", fixed(q, at) / unit_of(q), sigma(q, at) / unit_of(q));
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

/// Of the mean square of the horizontal position error; the last: the correlation between groups.
std::vector<double> horizontal_shares(const ErrorBudget& b) {
  const std::size_t end = b.time.size() - 1;
  const auto at = static_cast<Eigen::Index>(end);
  std::vector<double> out(b.groups.size() + 1, 0);
  double all = 0;
  for (const int q : {0, 1}) {
    const double square = b.mean(q, at) * b.mean(q, at) + b.covariance[end](q, q);
    const std::vector<double> shares = b.shares(q, end);
    for (std::size_t k = 0; k < out.size(); ++k) out[k] += square * shares[k];
    all += square;
  }
  for (double& share : out) share = all > 0 ? share / all : 0;
  return out;
}

template <class Value>
std::string row_text(const Value& value) {
  std::string text;
  for (Eigen::Index q = 0; q < budget_quantities; ++q) text += fmt::format("{}{:>9.3g}", q % 3 == 0 ? "  " : " ", value(q) / unit_of(q));
  return text;
}

std::string total_rows(const ErrorBudget& b) {
  const auto end = static_cast<Eigen::Index>(b.time.size()) - 1;
  return fmt::format("{:<24} fixed {}\n{:<24} sigma {}\n", "all together", row_text(b.mean.col(end)), "", row_text(total_sigma(b).col(end)));
}

/// Sources by their share, the largest first.
std::string source_rows(const ErrorBudget& b) {
  const auto end = static_cast<Eigen::Index>(b.time.size()) - 1;
  const std::vector<double> shares = horizontal_shares(b);
  std::vector<std::size_t> order(b.groups.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t x, std::size_t y) { return shares[x] > shares[y]; });
  std::string text;
  for (const std::size_t k : order) {
    const Contribution& c = b.groups[k];
    const bool drawn = !c.sigma.col(end).isZero(0), fixed = !c.fixed.col(end).isZero(0);
    std::string share = fmt::format("  {:>6.1f} %", std::round(1000 * shares[k]) / 10 + 0.0);
    if (fixed || !drawn) text += fmt::format("{:<24} fixed {}{}\n", c.name, row_text(c.fixed.col(end)), std::exchange(share, ""));
    if (drawn) text += fmt::format("{:<24} sigma {}{}\n", fixed ? "" : c.name, row_text(c.sigma.col(end)), share);
  }
  if (std::abs(shares.back()) > 5e-4) text += fmt::format("{:<124}  {:>6.1f} %\n", "correlation between groups", 100 * shares.back());
  return text;
}

std::string monte_carlo_rows(const ErrorDistribution& d) {
  const auto end = static_cast<Eigen::Index>(d.time.size()) - 1;
  return fmt::format("{:<24} mean  {}\n{:<24} sigma {}\n", fmt::format("Monte Carlo, {} runs", d.drift.size()), row_text(d.mean.col(end)), "",
                     row_text(d.sigma.col(end))) +
         fmt::format("{:<24} 5 %   {}\n{:<24} 50 %  {}\n{:<24} 95 %  {}\n", "", row_text(d.low.col(end)), "", row_text(d.median.col(end)), "",
                     row_text(d.high.col(end))) +
         fmt::format(
             "\nhorizontal position: median {:.4g} m, 5..95 % {:.4g}..{:.4g} m; pure-inertial rate {:.3g} nmi/h RMS, CEP {:.3g} nmi/h, "
             "95 % {:.3g} nmi/h\n",
             d.median(budget_quantities, end), d.low(budget_quantities, end), d.high(budget_quantities, end), d.drift_rms / unit::nmi_per_h,
             d.drift_cep / unit::nmi_per_h, d.drift_95 / unit::nmi_per_h);
}

}  // namespace

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
        const double unit = unit_of(q), fixed = group ? b.groups[k].fixed(q, at) / unit : 0, sigma = group ? b.groups[k].sigma(q, at) / unit : 0;
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
      text += fmt::format(",{:.8g},{:.8g},{:.8g}", d.low(q, at) / unit_of(q), d.median(q, at) / unit_of(q), d.high(q, at) / unit_of(q));
    text += '\n';
  }
  return text;
}

std::string budget_table(const ErrorBudget& b, const std::optional<ErrorDistribution>& monte_carlo) {
  std::string text = fmt::format("Errors after {:g} s, {}: fixed errors, and one sigma of drawn ones\n\n", b.time.back(), vertical_text(b.vertical));
  text += fmt::format("{:<31}  {:^29}  {:^29}  {:^29}  {:>7}\n", "", "position, m", "velocity, m/s", "attitude, arcsec", "share of");
  text += fmt::format("{:<31}", "");
  for (int triple = 0; triple < 3; ++triple) text += fmt::format("  {:>9} {:>9} {:>9}", "east", "north", "up");
  text += fmt::format("  {:>8}\n", "position");
  text += source_rows(b) + total_rows(b);
  return monte_carlo ? text + monte_carlo_rows(*monte_carlo) : text;
}

}  // namespace imulab
