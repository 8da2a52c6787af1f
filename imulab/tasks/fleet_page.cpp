#include "imulab/tasks/fleet_page.hpp"

#include "imulab/fleet/statistics/control.hpp"
#include "imulab/fleet/statistics/stated.hpp"
#include "imulab/formats/text/figures.hpp"
#include "imulab/report/html.hpp"
#include "imulab/report/page.hpp"
#include "imulab/report/pictures.hpp"
#include "imulab/tasks/fleet_figures.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace imulab {

namespace report {
namespace {

constexpr std::size_t most_rows = 50;    // of a table
constexpr std::size_t most_serials = 8;  // in a sentence

std::string code(CoefficientIndex index) { return "<code>" + escaped(coefficient(index).name) + "</code>"; }

/// A fleet, and where its units' pages are.
struct Fleet {
  const FleetStatistics& statistics;
  const std::vector<std::string>& links;

  std::string unit_name(Eigen::Index unit) const {
    const auto k = static_cast<std::size_t>(unit);
    const std::string name = escaped(shortened(statistics.sample.units[k], 60));
    return linked(k, name);
  }
  std::string serial_link(Eigen::Index unit) const {
    const auto k = static_cast<std::size_t>(unit);
    return linked(k, escaped(shortened(k < statistics.sample.serials.size() ? statistics.sample.serials[k] : statistics.sample.units[k], 40)));
  }
  std::string linked(std::size_t k, const std::string& name) const {
    return k < links.size() && !links[k].empty() ? fmt::format("<a href=\"{}\">{}</a>", escaped(links[k]), name) : name;
  }
};

bool differs(const std::optional<Gauge>& gauge, double level) { return gauge && gauge->p_value < level; }

PageVerdict fleet_verdict(const FleetStatistics& f) {
  const double level = f.search.false_alarm / static_cast<double>(std::max<std::size_t>(1, f.coefficients.size()));
  const auto different = [&](std::optional<Gauge> CoefficientStatistics::*gauge) {
    return std::count_if(f.coefficients.begin(), f.coefficients.end(), [&](const CoefficientStatistics& c) { return differs(c.*gauge, level); });
  };
  const auto stations = different(&CoefficientStatistics::stations), operators = different(&CoefficientStatistics::operators);
  std::string incapable;
  std::set<Eigen::Index> beyond;
  for (const CoefficientStatistics& c : f.coefficients) {
    if (c.capability && c.capability->cpk < 1)
      incapable += fmt::format("{}{} ({})", incapable.empty() ? "" : ", ", coefficient(c.index).name, number_text(c.capability->cpk));
    for (const Eigen::Index row : beyond_limit(f, c)) beyond.insert(row);
  }
  PageVerdict v;
  if (!f.search.outliers.empty())
    v.because.push_back(
        fmt::format("{} {}", text::plural(f.search.outliers.size(), "unit"), f.search.outliers.size() == 1 ? "is an outlier" : "are outliers"));
  if (!f.drifts.empty()) v.because.push_back(fmt::format("{} coefficients of units drift beyond what their calibrations explain", f.drifts.size()));
  if (stations > 0) v.because.push_back(fmt::format("stations differ in {} coefficients", stations));
  if (operators > 0) v.because.push_back(fmt::format("operators differ in {} coefficients", operators));
  if (!incapable.empty()) v.because.push_back("spread beyond the limits, Cpk below 1: " + incapable);
  if (!beyond.empty()) {
    std::string serials;
    std::size_t named = 0;
    for (auto row = beyond.begin(); row != beyond.end() && named < most_serials; ++row, ++named)
      serials += (named > 0 ? ", " : "") + shortened(serial_of_row(f, *row), 40);
    v.because.push_back(fmt::format("{} of {} units {} beyond a limit: {}{}", beyond.size(), f.sample.units.size(), beyond.size() == 1 ? "is" : "are",
                                    serials, beyond.size() > named ? ", and others" : ""));
  }
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

/// Coefficients in which something stands out.
bool is_significant(const FleetStatistics& f, const CoefficientStatistics& c) {
  const double level = f.search.false_alarm / static_cast<double>(std::max<std::size_t>(1, f.coefficients.size()));
  bool out = differs(c.stations, level) || differs(c.operators, level);
  for (std::size_t rule = 0; rule < run_rule_count; ++rule) out = out || stands_out(c.chart, rule);
  for (const FleetOutlier& o : f.search.outliers)
    out = out || f.sample.coefficients[static_cast<std::size_t>(f.sample.common[static_cast<std::size_t>(o.worst)])] == c.index;
  return out;
}

std::string overview_section(const FleetStatistics& f) {
  const std::string picture = fleet_overview(f);
  if (picture.empty()) return "";
  const bool many = f.sample.units.size() > 60;
  return section(
      "overview", "All units at a glance",
      many ? "Each unit's difference from the mean in the standard deviation that it should have. Thick: half of the units; thin: 95 %; red: "
             "units beyond 3, and the farthest by its serial number."
           : "Each dot is a unit: its difference from the mean in the standard deviation that it should have. Red: beyond 3; the farthest by "
             "its serial number.",
      figure(picture, "", true));
}

/// The required coefficients, with the units beyond their limits.
std::string limits_section(const Fleet& fleet) {
  const FleetStatistics& f = fleet.statistics;
  Table t{.head = {"coefficient", "limit", "", "mean", "spread", "Cp", "Cpk", "units beyond", "the farthest"}, .rows = {}, .left = {2, 8}};
  std::string charts;
  for (const CoefficientStatistics& c : f.coefficients) {
    if (!c.capability) continue;
    const std::vector<Eigen::Index> beyond = beyond_limit(f, c);
    std::string serials;
    for (std::size_t k = 0; k < std::min(beyond.size(), most_serials); ++k)
      serials += (k > 0 ? ", " : "") + fleet.serial_link(f.sample.unit[static_cast<std::size_t>(beyond[k])]);
    if (beyond.size() > most_serials) serials += ", …";
    t.rows.push_back({code(c.index), "± " + number_text(c.capability->limit / c.size), escaped(readable_unit(c.unit)),
                      number_text((c.fleet.mean - c.capability->target) / c.size), number_text(c.fleet.spread / c.size),
                      number_text(c.capability->cp),
                      (c.capability->cpk < 1 ? "<strong>" + number_text(c.capability->cpk) + "</strong>" : number_text(c.capability->cpk)),
                      fmt::format("{}", beyond.size()), serials});
    charts += coefficient_charts(f, c);
  }
  if (t.rows.empty()) return "";
  return section(
      "limits", "Against the limits",
      "Mean: from the target. Cpk below 1: the spread reaches beyond a limit. Red, dashed: the limits; red dots: units beyond them, by their "
      "serial numbers.",
      table(t) + (charts.empty() ? "" : charts_key()) + charts);
}

std::string charts_section(const FleetStatistics& f) {
  std::string significant, others;
  for (const CoefficientStatistics& c : f.coefficients)
    if (!c.capability) (is_significant(f, c) ? significant : others) += coefficient_charts(f, c);
  return section("charts", "Each coefficient over the fleet",
                 "Left: how many units are how far from the mean, and the normal distribution that spread and uncertainty make. Right: the units in "
                 "the order of their times, each in the standard deviation that it should have; dashed: three of them; red: where a run rule fires "
                 "(Nelson 1984).",
                 charts_key() + (significant.empty() ? paragraph("Nothing stands out in the coefficients without a limit.") : significant) +
                     (others.empty() ? "" : folded(significant.empty() ? "Their charts" : "Coefficients in which nothing stands out", others)));
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
    if (histories.size() < most_histories) histories.push_back(unit_history(f, *c, d.drift));
  }
  return section("drift", "Drift",
                 "A line through each unit's calibrations. Repeatability: how far a unit is from its line beyond the uncertainties. Listed are units "
                 "whose drift the "
                 "calibrations do not explain; the band is two standard uncertainties with the repeatability.",
                 (t.rows.empty() ? "" : table(t)) + (histories.empty() ? "" : history_key()) + beside(histories) + table(means));
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
  for (const CoefficientStatistics& c : f.coefficients) {
    const std::vector<Eigen::Index> beyond = report::beyond_limit(f, c);
    for (std::size_t k = 0; k < std::min(beyond.size(), report::most_serials); ++k) units.insert(f.sample.unit[static_cast<std::size_t>(beyond[k])]);
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
  page.body = overview_section(f) + limits_section(fleet) + outlier_section(fleet) + drift_section(fleet) + due_section(fleet) + gauge_section(f) +
              spread_section(f) + charts_section(f) + correlation_section(f);
  return page_text(page);
}

}  // namespace imulab
