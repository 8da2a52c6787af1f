#include "imulab/tasks/fleet_figures.hpp"

#include "imulab/report/html.hpp"
#include "imulab/report/plot.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace imulab::report {
namespace {

constexpr std::string_view fleet_ink = "var(--ink)";
constexpr std::size_t most_units = 500;  // of a chart: the last ones
constexpr std::size_t most_named = 6;    // units with their serial numbers beside them

Eigen::Index column_of(const FleetStatistics& f, CoefficientIndex index) {
  return std::find(f.sample.coefficients.begin(), f.sample.coefficients.end(), index) - f.sample.coefficients.begin();
}

/// Of each unit, in the order of the chart, from the limits' middle where there are limits, else from the mean: user units.
std::vector<double> values_of(const FleetStatistics& f, const CoefficientStatistics& c) {
  const double from = c.capability ? c.capability->target : c.fleet.mean;
  std::vector<double> out;
  for (const Eigen::Index row : c.rows) out.push_back((f.sample.values(row, column_of(f, c.index)) - from) / c.size);
  return out;
}

std::string from_text(const CoefficientStatistics& c) {
  return fmt::format("from the {} [{}]", c.capability ? "target" : "mean", readable_unit(c.unit));
}

/// And the normal distribution with the fleet's spread and mean uncertainty.
std::string histogram(const FleetStatistics& f, const CoefficientStatistics& c) {
  const double sigma = std::hypot(c.fleet.spread, c.fleet.measurement) / c.size;
  const double limit = c.capability ? c.capability->limit / c.size : 0, mean = c.capability ? (c.fleet.mean - c.capability->target) / c.size : 0;
  const std::vector<double> values = values_of(f, c);
  double reach = std::max(4 * sigma + std::abs(mean), 1.15 * limit);
  for (const double value : values) reach = std::max(reach, std::abs(value));
  const auto bins = static_cast<std::size_t>(std::clamp(2 * std::cbrt(static_cast<double>(values.size())) * reach / (3.5 * sigma), 8.0, 80.0));
  const double width = 2 * reach / static_cast<double>(bins);
  std::vector<double> x(bins), count(bins), curve_x, curve;
  for (std::size_t k = 0; k < bins; ++k) x[k] = -reach + (static_cast<double>(k) + 0.5) * width;
  for (const double value : values) count[std::min(bins - 1, static_cast<std::size_t>((value + reach) / width))] += 1;
  for (int k = 0; k <= 200; ++k) {
    const double at = reach * (0.01 * k - 1);
    curve_x.push_back(at);
    curve.push_back(static_cast<double>(values.size()) * width / (sigma * std::sqrt(2 * std::numbers::pi)) *
                    std::exp(-0.5 * (at - mean) * (at - mean) / (sigma * sigma)));
  }
  const double top = 1.1 * std::max(*std::max_element(count.begin(), count.end()), *std::max_element(curve.begin(), curve.end()));
  Plot plot({from_text(c), -reach, reach}, {"units", 0, top}, "histogram");
  plot.bars(x, count, width, color::sky);
  plot.line(curve_x, curve, fleet_ink);
  if (c.capability)
    for (const double side : {-limit, limit}) plot.segment(side, 0, side, top, color::vermilion, true);
  return plot.svg();
}

/// Where a rule of Nelson's fires; of a coefficient with limits what is beyond them.
std::vector<bool> marked_units(const CoefficientStatistics& c, const std::vector<double>& values) {
  std::vector<bool> out(values.size());
  for (std::size_t k = 0; k < values.size(); ++k) {
    if (c.capability) out[k] = std::abs(values[k]) > c.capability->limit / c.size;
    for (const auto& rule : c.chart.fired)
      if (!c.capability && std::binary_search(rule.begin(), rule.end(), static_cast<Eigen::Index>(k))) out[k] = true;
  }
  return out;
}

std::string units_picture(const FleetStatistics& f, const CoefficientStatistics& c) {
  std::vector<double> values = values_of(f, c);
  if (!c.capability) values.assign(c.chart.scores.begin(), c.chart.scores.end());
  const std::vector<bool> marked = marked_units(c, values);
  const std::size_t n = values.size(), first = n > most_units ? n - most_units : 0;
  const double limit = c.capability ? c.capability->limit / c.size : 3;
  std::vector<double> x, y, far_x, far_y;
  std::vector<std::size_t> far;
  double reach = 1.3 * limit;
  for (std::size_t k = first; k < n; ++k) {
    (marked[k] ? far_x : x).push_back(static_cast<double>(k + 1)), (marked[k] ? far_y : y).push_back(values[k]);
    if (marked[k]) far.push_back(k);
    reach = std::max(reach, 1.1 * std::abs(values[k]));
  }
  const auto serial = [&](std::size_t k) { return shortened(serial_of_row(f, c.rows[k]), 16); };
  Plot plot({fmt::format("units by time: {} to {}", serial(first), serial(n - 1)), static_cast<double>(first), static_cast<double>(n) + 1},
            {c.capability ? from_text(c) : "standard deviations", -reach, reach}, "units");
  for (const double side : {-limit, limit}) plot.rule(side, color::vermilion);
  plot.rule(0, color::gray);
  plot.dots(x, y, color::blue);
  plot.dots(far_x, far_y, color::vermilion);
  std::sort(far.begin(), far.end(), [&](std::size_t a, std::size_t b) { return std::abs(values[a]) > std::abs(values[b]); });
  for (std::size_t k = 0; k < std::min(far.size(), most_named); ++k) {
    const bool right = far[k] - first > (n - first) * 4 / 5;
    plot.note(static_cast<double>(far[k] + 1), values[far[k]], serial(far[k]), right ? Anchor::end : Anchor::start, right ? -7 : 7, 4);
  }
  return plot.svg();
}

}  // namespace

std::string serial_of_row(const FleetStatistics& f, Eigen::Index row) {
  const auto unit = static_cast<std::size_t>(f.sample.unit[static_cast<std::size_t>(row)]);
  return unit < f.sample.serials.size() ? f.sample.serials[unit] : f.sample.units[unit];
}

std::vector<Eigen::Index> beyond_limit(const FleetStatistics& f, const CoefficientStatistics& c) {
  if (!c.capability) return {};
  const auto distance = [&](Eigen::Index row) { return std::abs(f.sample.values(row, column_of(f, c.index)) - c.capability->target); };
  std::vector<Eigen::Index> out;
  for (const Eigen::Index row : c.rows)
    if (distance(row) > c.capability->limit) out.push_back(row);
  std::stable_sort(out.begin(), out.end(), [&](Eigen::Index a, Eigen::Index b) { return distance(a) > distance(b); });
  return out;
}

std::string fleet_overview(const FleetStatistics& f) {
  constexpr double left = 170, right = 640, width = 840, step = 17, top = 6, reach = 6, all_dots = 60;
  const auto at = [&](double score) { return left + (std::clamp(score, -reach, reach) + reach) / (2 * reach) * (right - left); };
  std::string rows;
  double y = top;
  for (const CoefficientStatistics& c : f.coefficients) {
    if (!(std::hypot(c.fleet.spread, c.fleet.measurement) > 0) || c.rows.size() < 2) continue;
    const double middle = y + 0.5 * step;
    const Eigen::ArrayXd& scores = c.chart.scores;
    const bool many = static_cast<double>(scores.size()) > all_dots;
    std::string near, far;
    Eigen::Index farthest = 0;
    for (Eigen::Index k = 0; k < scores.size(); ++k) {
      if (std::abs(scores[k]) > std::abs(scores[farthest])) farthest = k;
      if (std::abs(scores[k]) > 3)
        far += fmt::format("M{:.1f} {:.1f}h0", at(scores[k]), middle);
      else if (!many)
        near += fmt::format("M{:.1f} {:.1f}h0", at(scores[k]), middle);
    }
    if (many) {
      std::vector<double> sorted(scores.begin(), scores.end());
      std::sort(sorted.begin(), sorted.end());
      const auto quantile = [&](double p) {
        return std::clamp(sorted[static_cast<std::size_t>(p * static_cast<double>(sorted.size() - 1))], -3.0, 3.0);
      };
      rows += line_between(at(quantile(0.025)), middle, at(quantile(0.975)), middle, color::sky, 3) +
              line_between(at(quantile(0.25)), middle, at(quantile(0.75)), middle, color::blue, 6);
    }
    for (const auto& [path, stroke] : {std::pair{near, color::blue}, {far, color::vermilion}})
      if (!path.empty())
        rows += fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"5\" stroke-linecap=\"round\"/>", path, stroke);
    rows += text_at(left - 8, middle + 4, coefficient(c.index).name, Anchor::end);
    const std::string beyond = c.capability ? fmt::format("Cpk {}", number_text(c.capability->cpk, 2)) : "";
    const std::string unit = std::abs(scores[farthest]) > 3
                                 ? fmt::format("{}: {}{}", shortened(serial_of_row(f, c.rows[static_cast<std::size_t>(farthest)]), 16),
                                               scores[farthest] > 0 ? "+" : "", number_text(scores[farthest], 2))
                                 : "";
    rows += text_at(right + 12, middle + 4, beyond + (beyond.empty() || unit.empty() ? "" : ", ") + unit);
    y += step;
  }
  if (rows.empty()) return {};
  std::string frame;
  for (const double v : {-6.0, -3.0, 0.0, 3.0, 6.0}) {
    frame += line_between(at(v), top, at(v), y, std::abs(v) == 3 ? color::vermilion : color::grid, 1, std::abs(v) == 3);
    frame += text_at(at(v), y + 15, tick_text(v), Anchor::middle);
  }
  return svg_text(width, y + 38, "all units in all coefficients",
                  frame + rows + text_at(0.5 * (left + right), y + 32, "standard deviations from the mean (6 and more at the edge)", Anchor::middle));
}

std::string coefficient_charts(const FleetStatistics& f, const CoefficientStatistics& c) {
  if (!(std::hypot(c.fleet.spread, c.fleet.measurement) > 0) || c.rows.size() < 2) return {};
  const std::string name(coefficient(c.index).name);
  return beside({figure(histogram(f, c), name), figure(units_picture(f, c), name + ", unit by unit")});
}

std::string charts_key() {
  return key({{"units", color::sky}, {"normal distribution", fleet_ink}, {"unit", color::blue}, {"limit, unit beyond it", color::vermilion}});
}

std::string history_key() { return key({{"calibration", color::blue}, {"drift", fleet_ink}, {"two standard uncertainties", color::sky}}); }

std::string unit_history(const FleetStatistics& f, const CoefficientStatistics& c, const UnitDrift& u) {
  const Eigen::Index column = column_of(f, c.index);
  std::vector<double> x, y, low, high;
  Eigen::Index its_row = 0;
  for (Eigen::Index row = 0; row < f.sample.time.size(); ++row) {
    if (f.sample.unit[static_cast<std::size_t>(row)] != u.unit || std::isnan(f.sample.values(row, column))) continue;
    const double sigma = std::hypot(std::sqrt(f.sample.variances(row, column)), c.drift.repeatability) / c.size;
    x.push_back(1970 + f.sample.time[row] / unit::year), y.push_back((f.sample.values(row, column) - c.fleet.mean) / c.size);
    low.push_back(y.back() - 2 * sigma), high.push_back(y.back() + 2 * sigma), its_row = row;
  }
  std::vector<double> all = low;
  all.insert(all.end(), high.begin(), high.end());
  Plot plot(axis_over("year", x), axis_over(fmt::format("from the fleet's mean [{}]", readable_unit(c.unit)), all), "history");
  plot.band(x, low, high, color::sky);
  plot.line({x.front(), x.back()}, {(u.last - u.slope * u.span - c.fleet.mean) / c.size, (u.last - c.fleet.mean) / c.size}, fleet_ink);
  plot.dots(x, y, color::blue);
  return figure(plot.svg(), fmt::format("{}, {}", shortened(serial_of_row(f, its_row), 40), coefficient(c.index).name));
}

}  // namespace imulab::report
