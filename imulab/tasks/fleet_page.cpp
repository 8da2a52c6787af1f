#include "imulab/tasks/fleet_page.hpp"

#include "imulab/core/units.hpp"
#include "imulab/fleet/statistics/stated.hpp"
#include "imulab/report/html.hpp"
#include "imulab/report/page.hpp"
#include "imulab/report/pictures.hpp"
#include "imulab/report/plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace imulab {

namespace report {
namespace {

constexpr std::size_t most_rows = 50;    // of a table
constexpr std::size_t most_units = 500;  // of a control chart: the last ones

std::string code(CoefficientIndex index) { return "<code>" + escaped(coefficient(index).name) + "</code>"; }

/// A fleet, and where its units' pages are.
struct Fleet {
  const FleetStatistics& statistics;
  const std::vector<std::string>& links;

  std::string unit_name(Eigen::Index unit) const {
    const auto k = static_cast<std::size_t>(unit);
    const std::string name = escaped(shortened(statistics.sample.units[k], 60));
    return k < links.size() && !links[k].empty() ? fmt::format("<a href=\"{}\">{}</a>", escaped(links[k]), name) : name;
  }
};

bool differs(const std::optional<Gauge>& gauge, double level) { return gauge && gauge->p_value < level; }

Verdict fleet_verdict(const FleetStatistics& f) {
  const double level = f.search.false_alarm / static_cast<double>(std::max<std::size_t>(1, f.coefficients.size()));
  const auto different = [&](std::optional<Gauge> CoefficientStatistics::*gauge) {
    return std::count_if(f.coefficients.begin(), f.coefficients.end(), [&](const CoefficientStatistics& c) { return differs(c.*gauge, level); });
  };
  const auto stations = different(&CoefficientStatistics::stations), operators = different(&CoefficientStatistics::operators);
  const auto incapable =
      std::count_if(f.coefficients.begin(), f.coefficients.end(), [](const auto& c) { return c.capability && c.capability->cpk < 1; });
  Verdict v;
  if (!f.search.outliers.empty()) v.because.push_back(fmt::format("{} units are outliers", f.search.outliers.size()));
  if (!f.drifts.empty()) v.because.push_back(fmt::format("{} coefficients of units drift beyond what their calibrations explain", f.drifts.size()));
  if (stations > 0) v.because.push_back(fmt::format("stations differ in {} coefficients", stations));
  if (operators > 0) v.because.push_back(fmt::format("operators differ in {} coefficients", operators));
  if (incapable > 0) v.because.push_back(fmt::format("{} coefficients spread beyond their limits: Cpk below 1", incapable));
  if (!f.search.possible) v.because.emplace_back("too few units for so many coefficients: outliers and correlations were not looked for");
  const bool good = v.because.empty();
  v.tone = good ? Tone::good : f.search.possible || v.because.size() > 1 ? Tone::doubtful : Tone::neutral;
  v.word = good ? "consistent" : v.tone == Tone::doubtful ? "look at it" : "small fleet";
  v.meaning = good ? "No unit, station or operator stands out, and no unit drifts beyond what its calibrations explain."
                   : "What stands out is listed below, with the probability of a false alarm that each test states.";
  return v;
}

std::string spread_section(const FleetStatistics& f) {
  Table t{.head = {"coefficient", "units", "mean", "spread", "95 % interval", "measured to", "", "p", "Cp", "Cpk"}, .rows = {}, .left = {6}};
  for (const CoefficientStatistics& c : f.coefficients) {
    const Coefficient& k = coefficient(c.index);
    const bool scale = is_scale(k);
    t.rows.push_back({code(c.index), fmt::format("{}", c.fleet.units), number_text(scale ? c.fleet.mean : c.fleet.mean / c.size, scale ? 7 : 3),
                      number_text(c.fleet.spread / c.size),
                      fmt::format("{} to {}", number_text(c.fleet.spread_low / c.size, 2), number_text(c.fleet.spread_high / c.size, 2)),
                      number_text(c.fleet.measurement / c.size, 2), escaped(readable_unit(c.unit)), number_text(c.fleet.p_value, 2),
                      c.capability ? number_text(c.capability->cp) : "", c.capability ? number_text(c.capability->cpk) : ""});
  }
  const std::string left_out = left_out_text(f);
  return section(
      "spread", "Spread between units",
      "The standard deviation of the units themselves, without the uncertainty with which they were measured (random effects, restricted maximum "
      "likelihood; the interval is the profile's). p: probability of such differences between units that are all the same. Scales are given as "
      "they are, all else in the unit at the right." +
          (left_out.empty() ? "" : fmt::format(" {}: {}.", left_out_reason, escaped(left_out))),
      table(t));
}

/// A histogram of the units, and the normal distribution with the fleet's spread and mean uncertainty.
std::string histogram(const FleetStatistics& f, const CoefficientStatistics& c) {
  const Eigen::Index column = std::find(f.sample.coefficients.begin(), f.sample.coefficients.end(), c.index) - f.sample.coefficients.begin();
  const double sigma = std::hypot(c.fleet.spread, c.fleet.measurement) / c.size;
  std::vector<double> values;
  for (const Eigen::Index row : c.rows) values.push_back((f.sample.values(row, column) - c.fleet.mean) / c.size);
  const double reach =
      std::max(4 * sigma, std::abs(*std::max_element(values.begin(), values.end(), [](double a, double b) { return std::abs(a) < std::abs(b); })));
  const auto bins = static_cast<std::size_t>(std::clamp(2 * std::cbrt(static_cast<double>(values.size())) * reach / (3.5 * sigma), 8.0, 80.0));
  const double width = 2 * reach / static_cast<double>(bins);
  std::vector<double> x(bins), count(bins), curve_x, curve;
  for (std::size_t k = 0; k < bins; ++k) x[k] = -reach + (static_cast<double>(k) + 0.5) * width;
  for (const double value : values) count[std::min(bins - 1, static_cast<std::size_t>((value + reach) / width))] += 1;
  for (int k = 0; k <= 200; ++k) {
    const double at = reach * (0.01 * k - 1);
    curve_x.push_back(at);
    curve.push_back(static_cast<double>(values.size()) * width / (sigma * std::sqrt(2 * 3.14159265358979)) *
                    std::exp(-0.5 * at * at / (sigma * sigma)));
  }
  const double top = 1.1 * std::max(*std::max_element(count.begin(), count.end()), *std::max_element(curve.begin(), curve.end()));
  Plot plot({fmt::format("from the mean [{}]", readable_unit(c.unit)), -reach, reach}, {"units", 0, top}, "histogram");
  plot.bars(x, count, width, color::sky);
  plot.line(curve_x, curve, color::ink);
  return plot.svg();
}

std::string control_picture(const CoefficientStatistics& c) {
  const auto n = static_cast<std::size_t>(c.chart.scores.size()), first = n > most_units ? n - most_units : 0;
  std::vector<double> x, y, far_x, far_y;
  for (std::size_t k = first; k < n; ++k) {
    const double score = c.chart.scores[static_cast<Eigen::Index>(k)];
    bool fired = false;
    for (const auto& rule : c.chart.fired) fired = fired || std::binary_search(rule.begin(), rule.end(), static_cast<Eigen::Index>(k));
    (fired ? far_x : x).push_back(static_cast<double>(k + 1));
    (fired ? far_y : y).push_back(score);
  }
  double reach = 4;
  for (const double score : far_y) reach = std::max(reach, 1.1 * std::abs(score));
  Plot plot({"units in the order of their times", static_cast<double>(first), static_cast<double>(n) + 1}, {"standard deviations", -reach, reach},
            "control chart");
  for (const double limit : {-3.0, 3.0}) plot.rule(limit, color::vermilion);
  plot.rule(0, color::gray);
  plot.dots(x, y, color::blue);
  plot.dots(far_x, far_y, color::vermilion);
  return plot.svg();
}

std::string charts_section(const FleetStatistics& f) {
  std::string main, others;
  for (const CoefficientStatistics& c : f.coefficients) {
    if (!(std::hypot(c.fleet.spread, c.fleet.measurement) > 0) || c.rows.size() < 2) continue;
    const std::string name(coefficient(c.index).name);
    (is_optional(coefficient(c.index).term) ? others : main) +=
        beside({figure(histogram(f, c), name), figure(control_picture(c), name + ": control chart")});
  }
  return section("charts", "Each coefficient over the fleet",
                 "Left: how many units are how far from the mean, and the normal distribution that spread and uncertainty make. Right: the units in "
                 "the order of "
                 "their times, each in the standard deviation that it should have; dashed: three of them; red: where a run rule fires (Nelson 1984).",
                 main + (others.empty() ? "" : folded("Optional terms", others)));
}

std::string outlier_section(const Fleet& fleet) {
  const FleetStatistics& f = fleet.statistics;
  if (f.search.outliers.empty()) return "";
  Table t{.head = {"unit", "distance", "coefficients", "p", "farthest", "standard deviations"}, .rows = {}, .left = {4}};
  for (const FleetOutlier& o : f.search.outliers) {
    if (t.rows.size() == most_rows) break;
    const Eigen::Index row = f.sample.last[static_cast<std::size_t>(o.unit)];
    t.rows.push_back({fleet.unit_name(f.sample.unit[static_cast<std::size_t>(row)]), number_text(o.distance), fmt::format("{}", o.coefficients),
                      number_text(o.p_value, 2),
                      code(f.sample.coefficients[static_cast<std::size_t>(f.sample.common[static_cast<std::size_t>(o.worst)])]),
                      number_text(o.worst_sigmas)});
  }
  return section(
      "outliers", "Outliers",
      fmt::format("Mahalanobis distance from the fleet's mean in the unit's own covariance and the spread between units. In a fleet without outliers "
                  "the probability of any in this table is {} %. Spread and mean leave them out.{}",
                  number_text(100 * f.search.false_alarm, 2),
                  f.search.outliers.size() > most_rows ? fmt::format(" The farthest {} are shown.", most_rows) : ""),
      table(t));
}

/// One unit's calibrations of a coefficient over the years, with two standard uncertainties, and its line.
std::string history(const FleetStatistics& f, const CoefficientStatistics& c, const UnitDrift& u) {
  const Eigen::Index column = std::find(f.sample.coefficients.begin(), f.sample.coefficients.end(), c.index) - f.sample.coefficients.begin();
  std::vector<double> x, y, low, high;
  for (Eigen::Index row = 0; row < f.sample.time.size(); ++row) {
    if (f.sample.unit[static_cast<std::size_t>(row)] != u.unit || std::isnan(f.sample.values(row, column))) continue;
    const double sigma = std::hypot(std::sqrt(f.sample.variances(row, column)), c.drift.repeatability) / c.size;
    x.push_back(1970 + f.sample.time[row] / unit::year), y.push_back((f.sample.values(row, column) - c.fleet.mean) / c.size);
    low.push_back(y.back() - 2 * sigma), high.push_back(y.back() + 2 * sigma);
  }
  std::vector<double> all = low;
  all.insert(all.end(), high.begin(), high.end());
  Plot plot(axis_over("year", x), axis_over(fmt::format("from the fleet's mean [{}]", readable_unit(c.unit)), all), "history");
  plot.band(x, low, high, color::sky);
  plot.line({x.front(), x.back()}, {(u.last - u.slope * u.span - c.fleet.mean) / c.size, (u.last - c.fleet.mean) / c.size}, color::ink);
  plot.dots(x, y, color::blue);
  return figure(plot.svg(), fmt::format("{}, {}", shortened(f.sample.units[static_cast<std::size_t>(u.unit)], 40), coefficient(c.index).name));
}

std::string drift_section(const Fleet& fleet) {
  const FleetStatistics& f = fleet.statistics;
  Table means{.head = {"coefficient", "units", "mean per year", "95 % interval", "spread of it", "repeatability", ""}, .rows = {}, .left = {6}};
  for (const CoefficientStatistics& c : f.coefficients)
    if (c.mean_drift)
      means.rows.push_back(
          {code(c.index), fmt::format("{}", c.drift.units.size()), number_text(c.mean_drift->mean / c.size),
           fmt::format("{} to {}", number_text(c.mean_drift->mean_low / c.size, 2), number_text(c.mean_drift->mean_high / c.size, 2)),
           number_text(c.mean_drift->spread / c.size, 2), number_text(c.drift.repeatability / c.size, 2), escaped(readable_unit(c.unit))});
  if (means.rows.empty()) return "";
  Table t{.head = {"unit", "coefficient", "calibrations", "years", "per year", "95 % interval", "", "p"}, .rows = {}, .left = {1, 6}};
  std::vector<std::string> histories;
  constexpr std::size_t most_histories = 6;
  for (const SignificantDrift& d : f.drifts) {
    if (t.rows.size() == most_rows) break;
    const auto c = std::find_if(f.coefficients.begin(), f.coefficients.end(), [&](const auto& x) { return x.index == d.index; });
    t.rows.push_back({fleet.unit_name(d.drift.unit), code(d.index), fmt::format("{}", d.drift.calibrations), number_text(d.drift.span, 2),
                      number_text(d.drift.slope / c->size),
                      fmt::format("{} to {}", number_text(d.drift.low / c->size, 2), number_text(d.drift.high / c->size, 2)),
                      escaped(readable_unit(c->unit)), number_text(d.drift.p_value, 2)});
    if (histories.size() < most_histories) histories.push_back(history(f, *c, d.drift));
  }
  return section("drift", "Drift",
                 "A line through each unit's calibrations. Repeatability: how far a unit is from its line beyond the uncertainties. Listed are units "
                 "whose drift the "
                 "calibrations do not explain; the band is two standard uncertainties with the repeatability.",
                 (t.rows.empty() ? "" : table(t)) + beside(histories) + table(means));
}

std::string due_section(const Fleet& fleet) {
  Table t{.head = {"unit", "due", "for"}, .rows = {}, .left = {1, 2}};
  for (const UnitDue& d : fleet.statistics.due)
    if (t.rows.size() < most_rows) t.rows.push_back({fleet.unit_name(d.unit), due_text(d), code(d.coefficient)});
  if (t.rows.empty()) return "";
  return section("due", "Due for calibration",
                 "Before this day the error since the unit's last calibration stays within its limit, at 95 %: by the unit's drift and that of the "
                 "fleet, the uncertainty of the calibration, and how well units repeat.",
                 table(t));
}

std::string gauge_rows(const FleetStatistics& f, std::optional<Gauge> CoefficientStatistics::*which, const std::vector<std::string>& names,
                       const char* what) {
  Table t{.head = {"coefficient", what, "calibrations", "bias", "95 % interval", "", "p of all"}, .rows = {}, .left = {1, 5}};
  const double level = f.search.false_alarm / static_cast<double>(std::max<std::size_t>(1, f.coefficients.size()));
  for (const CoefficientStatistics& c : f.coefficients) {
    const std::optional<Gauge>& g = c.*which;
    if (!differs(g, level)) continue;
    for (std::size_t k = 0; k < g->levels.size() && t.rows.size() < most_rows; ++k)
      if (const GaugeLevel& l = g->levels[k]; l.calibrations > 0)
        t.rows.push_back({code(c.index), escaped(shortened(names[k].empty() ? "(none)" : names[k], 40)), fmt::format("{}", l.calibrations),
                          number_text(l.bias / c.size), fmt::format("{} to {}", number_text(l.low / c.size, 2), number_text(l.high / c.size, 2)),
                          escaped(readable_unit(c.unit)), number_text(g->p_value, 2)});
  }
  return t.rows.empty() ? "" : table(t);
}

std::string gauge_section(const FleetStatistics& f) {
  const std::string rows = gauge_rows(f, &CoefficientStatistics::stations, f.sample.stations, "station") +
                           gauge_rows(f, &CoefficientStatistics::operators, f.sample.operators, "operator");
  if (rows.empty()) return "";
  return section("stations", "Stations and operators that differ", "Bias from the mean of all, beyond what chance explains among all coefficients.",
                 rows);
}

std::string correlation_section(const FleetStatistics& f) {
  if (!f.search.possible || f.correlation.size() == 0) return "";
  std::vector<std::string> names;
  for (const Eigen::Index k : f.sample.common) names.emplace_back(coefficient(f.sample.coefficients[static_cast<std::size_t>(k)]).name);
  return section("correlation", "Correlation between units",
                 fmt::format("Apart from that of the measurement. {} are beyond what chance explains.", f.correlations.size()),
                 figure(correlation_map(names, f.correlation, "correlations between units"), "blue: positive, orange: negative", true));
}

}  // namespace
}  // namespace report

std::vector<Eigen::Index> units_on_page(const FleetStatistics& f) {
  std::set<Eigen::Index> units;
  const auto first = [](std::size_t count) { return std::min(count, report::most_rows); };
  for (std::size_t k = 0; k < first(f.search.outliers.size()); ++k) {
    const Eigen::Index row = f.sample.last[static_cast<std::size_t>(f.search.outliers[k].unit)];
    units.insert(f.sample.unit[static_cast<std::size_t>(row)]);
  }
  for (std::size_t k = 0; k < first(f.drifts.size()); ++k) units.insert(f.drifts[k].drift.unit);
  for (std::size_t k = 0; k < first(f.due.size()); ++k) units.insert(f.due[k].unit);
  return {units.begin(), units.end()};
}

std::string fleet_page(const FleetStatistics& f, const std::string& title, const std::vector<std::string>& links) {
  using namespace report;
  const Fleet fleet{f, links};
  Page page;
  page.kind = "Fleet";
  page.title = shortened(title, 80);
  page.subtitle = "Each unit's last calibration, in the accelerometers' frame; drift and stations use its history.";
  page.verdict = fleet_verdict(f);
  page.figures = {{fmt::format("{}", f.sample.units.size()), "units"},
                  {fmt::format("{}", f.sample.calibration.size()), "calibrations"},
                  {f.search.possible ? fmt::format("{}", f.search.outliers.size()) : "not tested", "outliers"},
                  {fmt::format("{}", f.drifts.size()), "drifts"}};
  page.body = outlier_section(fleet) + drift_section(fleet) + due_section(fleet) + gauge_section(f) + spread_section(f) + charts_section(f) +
              correlation_section(f);
  return page_text(page);
}

}  // namespace imulab
