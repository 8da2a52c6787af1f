#include "imulab/fleet/statistics/stated.hpp"

#include "imulab/fleet/statistics/control.hpp"
#include "imulab/fleet/statistics/drift.hpp"
#include "imulab/formats/text/decimal.hpp"
#include "imulab/formats/text/figures.hpp"
#include "imulab/formats/text/json_fields.hpp"
#include "imulab/formats/text/printable.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace imulab {

namespace {

std::string coefficient_name(CoefficientIndex index) { return std::string(coefficient(index).name); }

const std::string& unit_name(const FleetStatistics& f, Eigen::Index unit) { return f.sample.units[static_cast<std::size_t>(unit)]; }

const std::string& outlier_name(const FleetStatistics& f, const FleetOutlier& o) {
  return f.sample.unit_of_row(f.sample.last[static_cast<std::size_t>(o.unit)]);
}

CoefficientIndex farthest_coefficient(const FleetStatistics& f, const FleetOutlier& o) {
  return f.sample.coefficients[static_cast<std::size_t>(f.sample.common[static_cast<std::size_t>(o.worst)])];
}

}  // namespace

// ---- JSON: the fields, which are written and not read

/// A part of a fleet's statistics, and where its names are.
template <class Part>
struct OfFleet {
  Part part;
  const FleetStatistics* fleet;
};

template <class Part>
std::vector<OfFleet<Part>> of_fleet(const std::vector<Part>& parts, const FleetStatistics& fleet) {
  std::vector<OfFleet<Part>> out;
  for (const Part& part : parts) out.push_back({part, &fleet});
  return out;
}

template <class Fields>
void describe(Fields& f, const RandomEffects& r) {
  f("units", r.units), f("mean", r.mean), f("mean_interval", std::array{r.mean_low, r.mean_high}), f("spread", r.spread);
  f("spread_interval", std::array{r.spread_low, r.spread_high}), f("measurement", r.measurement), f("p_value", r.p_value);
}

template <class Fields>
void describe(Fields& f, const Capability& c) {
  f("target", c.target), f("limit", c.limit), f("cp", c.cp), f("cp_interval", std::array{c.cp_low, c.cp_high}), f("cpk", c.cpk),
      f("outside", c.outside);
}

struct NamedLevel {
  std::string name;
  GaugeLevel level;
};

template <class Fields>
void describe(Fields& f, const NamedLevel& n) {
  f("name", n.name), f("calibrations", n.level.calibrations), f("bias", n.level.bias), f("interval", std::array{n.level.low, n.level.high});
}

template <class Fields>
void describe_gauge(Fields& f, std::string_view key, const std::optional<Gauge>& gauge, const std::vector<std::string>& names) {
  if (!gauge) return;
  std::vector<NamedLevel> levels;
  for (std::size_t k = 0; k < gauge->levels.size(); ++k)
    if (gauge->levels[k].calibrations > 0) levels.push_back({names[k], gauge->levels[k]});
  f.table(key, [&](auto& inner) {
    inner("levels", levels), inner("repeatability", gauge->repeatability), inner("reproducibility", gauge->reproducibility);
    inner("units_shared", gauge->units_shared), inner("p_value", gauge->p_value);
  });
}

struct FiredRule {
  std::string_view rule;
  std::size_t fired = 0;
  double expected = 0;
  std::vector<std::string> first_units;
};

template <class Fields>
void describe(Fields& f, const FiredRule& r) {
  f("rule", r.rule), f("fired", r.fired), f("expected", r.expected), f("first_units", r.first_units);
}

std::vector<FiredRule> fired_rules(const CoefficientStatistics& c, const FleetStatistics& f) {
  constexpr std::size_t most = 20;
  std::vector<FiredRule> out;
  for (std::size_t k = 0; k < run_rule_count; ++k) {
    FiredRule& rule = out.emplace_back();
    rule = {run_rules()[k].name, c.chart.fired[k].size(), run_rules()[k].false_alarm * static_cast<double>(c.rows.size()), {}};
    for (const Eigen::Index at : c.chart.fired[k])
      if (rule.first_units.size() < most) rule.first_units.push_back(f.sample.unit_of_row(c.rows[static_cast<std::size_t>(at)]));
  }
  return out;
}

template <class Fields>
void describe(Fields& f, const OfFleet<CoefficientStatistics>& of) {
  const CoefficientStatistics& c = of.part;
  f("name", c.index), f("fleet", c.fleet);
  f.table("user", [&](auto& user) {
    user("unit", c.unit), user("size", c.size), user("spread", c.fleet.spread / c.size), user("measurement", c.fleet.measurement / c.size);
  });
  f("control_limits", std::array{c.fleet.mean - c.control, c.fleet.mean + c.control}), f("run_rules", fired_rules(c, *of.fleet));
  f("capability", c.capability, fields::if_any);
  if (!c.drift.units.empty())
    f.table("drift", [&](auto& drift) {
      drift("units", c.drift.units.size()), drift("repeatability", c.drift.repeatability), drift("repeatability_p_value", c.drift.p_value);
      drift("per_year", c.mean_drift, fields::if_any);
    });
  describe_gauge(f, "stations", c.stations, of.fleet->sample.stations), describe_gauge(f, "operators", c.operators, of.fleet->sample.operators);
}

template <class Fields>
void describe(Fields& f, const OfFleet<FleetOutlier>& o) {
  f("unit", outlier_name(*o.fleet, o.part)), f("distance", o.part.distance), f("coefficients", o.part.coefficients), f("p_value", o.part.p_value);
  f("farthest", farthest_coefficient(*o.fleet, o.part)), f("sigmas", o.part.worst_sigmas);
}

template <class Fields>
void describe(Fields& f, const OfFleet<SignificantDrift>& d) {
  const UnitDrift& u = d.part.drift;
  f("unit", unit_name(*d.fleet, u.unit)), f("coefficient", d.part.index), f("calibrations", u.calibrations), f("span_years", u.span);
  f("per_year", u.slope), f("interval", std::array{u.low, u.high}), f("p_value", u.p_value);
}

template <class Fields>
void describe(Fields& f, const OfFleet<UnitDue>& d) {
  f("unit", unit_name(*d.fleet, d.part.unit)), f("coefficient", d.part.coefficient);
  f("time", std::isfinite(d.part.time) ? time_text(d.part.time) : std::string());
}

template <class Fields>
void describe(Fields& f, const SignificantCorrelation& c) {
  f("a", c.a), f("b", c.b), f("correlation", c.correlation);
}

template <class Fields>
void describe(Fields& f, const FleetStatistics& s) {
  f("units", s.sample.units.size()), f("calibrations", s.sample.calibration.size()), f("false_alarm", s.search.false_alarm);
  f("coefficients", of_fleet(s.coefficients, s)), f("left_out", s.sample.left_out), f("outliers_tested", s.search.possible);
  f("outliers", of_fleet(s.search.outliers, s)), f("drifts", of_fleet(s.drifts, s)), f("due", of_fleet(s.due, s)), f("correlations", s.correlations);
}

std::string left_out_text(const FleetStatistics& f) {
  std::string text;
  for (const CoefficientIndex index : f.sample.left_out) text += (text.empty() ? "" : ", ") + coefficient_name(index);
  return text;
}

std::string due_text(const UnitDue& due) {
  return std::isfinite(due.time) ? time_text(due.time).substr(0, 10) : fmt::format("not in {:g} years", due_horizon);
}

std::string fleet_statistics_json(const FleetStatistics& f) { return json_text(written(f)); }

namespace {

std::string spread_row(const CoefficientStatistics& c) {
  const auto in_unit = [&](double value) { return text::number(value / c.size, 2); };
  const Coefficient& k = coefficient(c.index);
  const std::string mean =
      is_scale(k) ? text::number(c.fleet.mean, 7) : text::to_digits_of(0.5 * (c.fleet.mean_high - c.fleet.mean_low) / c.size, c.fleet.mean / c.size);
  return fmt::format("{:<21} {:>10} {:>7} {:>7} {:>7} {:>8}  {}\n", k.name, mean, in_unit(c.fleet.spread), in_unit(c.fleet.spread_low),
                     in_unit(c.fleet.spread_high), in_unit(c.fleet.measurement), c.unit);
}

/// The coefficients that fewer units have than others, and those that only the prior sets.
std::string fewer_units_text(const FleetStatistics& f) {
  auto most = f.coefficients.empty() ? 0 : f.coefficients.front().fleet.units;
  for (const CoefficientStatistics& c : f.coefficients) most = std::max(most, c.fleet.units);
  std::string text;
  for (const CoefficientStatistics& c : f.coefficients)
    if (c.fleet.units < most) text += fmt::format("{}{} ({})", text.empty() ? "" : ", ", coefficient_name(c.index), c.fleet.units);
  if (!text.empty()) text = text::wrapped("", fmt::format("Of {} units, but: {}", most, text));
  if (!f.sample.left_out.empty()) text += text::wrapped("", fmt::format("{}: {}", left_out_reason, left_out_text(f)));
  return text;
}

std::string capability_text(const CoefficientStatistics& c) {
  if (!c.capability) return "";
  return fmt::format("  {:<21} Cp {:<6} Cpk {}\n", coefficient(c.index).name, text::number(c.capability->cp, 3), text::number(c.capability->cpk, 3));
}

/// Levels whose biases chance does not explain, among so many coefficients.
std::string gauge_text(const CoefficientStatistics& c, const Gauge& g, const std::vector<std::string>& names, const char* what, double level) {
  if (g.p_value >= level) return "";
  std::string text;
  for (std::size_t k = 0; k < g.levels.size(); ++k)
    if (g.levels[k].calibrations > 0)
      text += fmt::format(" {} {}", names[k].empty() ? "(none)" : one_line(names[k]),
                          text::to_digits_of(0.25 * (g.levels[k].high - g.levels[k].low) / c.size, g.levels[k].bias / c.size));
  return text::wrapped(fmt::format("  {:<21} {}: ", coefficient(c.index).name, what), fmt::format("{} {} from their mean", text, c.unit));
}

std::string rule_text(const CoefficientStatistics& c, const FleetStatistics& f) {
  std::string text;
  const auto n = static_cast<double>(c.rows.size());
  for (std::size_t k = 0; k < run_rule_count; ++k) {
    if (!stands_out(c.chart, k)) continue;
    const double expected = run_rules()[k].false_alarm * n, found = static_cast<double>(c.chart.fired[k].size());
    text += text::wrapped(fmt::format("  {:<21} ", coefficient(c.index).name),
                          fmt::format("{}: at {} units, {} expected; the first is {}", run_rules()[k].name, found, text::number(expected, 2),
                                      one_line(f.sample.unit_of_row(c.rows[static_cast<std::size_t>(c.chart.fired[k].front())]))));
  }
  return text;
}

std::string headed(const std::string& heading, const std::string& body) { return body.empty() ? "" : "\n" + heading + "\n" + body; }

}  // namespace

std::string fleet_statistics_text(const FleetStatistics& f) {
  std::string text = fmt::format("{}, {}; each unit's last one counts{}\n\n", text::plural(f.sample.units.size(), "unit"),
                                 text::plural(f.sample.calibration.size(), "calibration"), f.search.outliers.empty() ? "" : ", outliers apart");
  text += fmt::format("{:<21} {:>10} {:>7} {:>7} {:>7} {:>8}  unit\n", "coefficient", "mean", "spread", "low", "high", "measured");
  std::string gauge, rules, drift, capabilities;
  const double level = f.search.false_alarm / static_cast<double>(f.coefficients.size());
  for (const CoefficientStatistics& c : f.coefficients) {
    text += spread_row(c);
    if (c.stations) gauge += gauge_text(c, *c.stations, f.sample.stations, "stations", level);
    if (c.operators) gauge += gauge_text(c, *c.operators, f.sample.operators, "operators", level);
    rules += rule_text(c, f);
    capabilities += capability_text(c);
  }
  text += fewer_units_text(f) + headed("against the required limits", capabilities);
  std::string outliers, correlations, due;
  constexpr std::size_t most = 20;
  for (std::size_t k = 0; k < std::min(most, f.due.size()); ++k)
    due += text::wrapped(fmt::format("  {:<20} ", due_text(f.due[k])),
                         fmt::format("{}, for {}", one_line(unit_name(f, f.due[k].unit)), coefficient_name(f.due[k].coefficient)));
  for (std::size_t k = 0; k < std::min(most, f.search.outliers.size()); ++k) {
    const FleetOutlier& o = f.search.outliers[k];
    outliers += text::wrapped(fmt::format("  {}: ", one_line(outlier_name(f, o))),
                              fmt::format("distance {} in {} coefficients; {} is {:+.1f} standard deviations from the mean", text::number(o.distance),
                                          o.coefficients, coefficient_name(farthest_coefficient(f, o)), o.worst_sigmas));
  }
  for (std::size_t k = 0; k < std::min(most, f.drifts.size()); ++k) {
    const SignificantDrift& d = f.drifts[k];
    const auto c = std::find_if(f.coefficients.begin(), f.coefficients.end(), [&](const auto& x) { return x.index == d.index; });
    const double half = 0.5 * (d.drift.high - d.drift.low) / c->size;
    drift += text::wrapped(fmt::format("  {}: ", one_line(unit_name(f, d.drift.unit))),
                           fmt::format("{} {} {} per year (between {} and {}) over {} years", coefficient_name(d.index),
                                       text::to_digits_of(half, d.drift.slope / c->size), c->unit, text::to_digits_of(half, d.drift.low / c->size),
                                       text::to_digits_of(half, d.drift.high / c->size), text::number(d.drift.span, 2)));
  }
  for (std::size_t k = 0; k < std::min(most, f.correlations.size()); ++k)
    correlations += fmt::format("  {:<21} {:<21} {:+.2f}\n", coefficient_name(f.correlations[k].a), coefficient_name(f.correlations[k].b),
                                f.correlations[k].correlation);
  if (f.search.outliers.empty()) outliers = "  none\n";
  if (!f.search.possible) outliers = "  not tested: too few units for so many coefficients\n";
  text +=
      headed(fmt::format("{} outliers (probability of any false one {} %)", f.search.outliers.size(), text::number(100 * f.search.false_alarm, 2)),
             outliers);
  text += headed(fmt::format("{} drifts beyond what the calibrations explain", f.drifts.size()), drift);
  text += headed("due for calibration, the first of them", due);
  text += headed("stations and operators that differ", gauge);
  text += headed("production that is not steady", rules);
  text += headed(fmt::format("{} correlations between units", f.correlations.size()), correlations);
  return text;
}

}  // namespace imulab
