#include "imulab/results/fleet.hpp"

#include "imulab/formats/text/decimal.hpp"
#include "imulab/formats/text/figures.hpp"
#include "imulab/formats/text/json.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace imulab {

namespace {

std::string coefficient_name(CoefficientIndex index) { return std::string(coefficient(index).name); }

std::vector<std::string> left_out_names(const FleetStatistics& f) {
  std::vector<std::string> names;
  for (const CoefficientIndex index : f.sample.left_out) names.push_back(coefficient_name(index));
  return names;
}

JsonFields effects_json(const RandomEffects& r) {
  return {{{"units", r.units},
           {"mean", r.mean},
           {"mean_interval", std::vector{r.mean_low, r.mean_high}},
           {"spread", r.spread},
           {"spread_interval", std::vector{r.spread_low, r.spread_high}},
           {"measurement", r.measurement},
           {"p_value", r.p_value}}};
}

JsonFields gauge_json(const Gauge& g, const std::vector<std::string>& names) {
  std::vector<JsonFields> levels;
  for (std::size_t k = 0; k < g.levels.size(); ++k)
    if (g.levels[k].calibrations > 0)
      levels.push_back({{{"name", names[k]},
                         {"calibrations", g.levels[k].calibrations},
                         {"bias", g.levels[k].bias},
                         {"interval", std::vector{g.levels[k].low, g.levels[k].high}}}});
  return {{{"levels", levels},
           {"repeatability", g.repeatability},
           {"reproducibility", g.reproducibility},
           {"units_shared", g.units_shared},
           {"p_value", g.p_value}}};
}

JsonFields drift_json(const UnitDrift& u, const std::string& unit) {
  return {{{"unit", unit},
           {"calibrations", u.calibrations},
           {"span_years", u.span},
           {"per_year", u.slope},
           {"interval", std::vector{u.low, u.high}},
           {"p_value", u.p_value}}};
}

std::string outlier_name(const FleetStatistics& f, const FleetOutlier& o) {
  return f.sample.unit_of_row(f.sample.last[static_cast<std::size_t>(o.unit)]);
}

std::vector<JsonFields> rules_json(const CoefficientStatistics& c, const FleetStatistics& f) {
  constexpr std::size_t most = 20;
  std::vector<JsonFields> out;
  for (std::size_t k = 0; k < run_rule_count; ++k) {
    std::vector<std::string> first;
    for (const Eigen::Index at : c.chart.fired[k])
      if (first.size() < most) first.push_back(f.sample.unit_of_row(c.rows[static_cast<std::size_t>(at)]));
    out.push_back({{{"rule", std::string(run_rules()[k].name)},
                    {"fired", c.chart.fired[k].size()},
                    {"expected", run_rules()[k].false_alarm * static_cast<double>(c.rows.size())},
                    {"first_units", first}}});
  }
  return out;
}

JsonFields coefficient_json(const CoefficientStatistics& c, const FleetStatistics& f) {
  JsonFields out{
      {{"name", coefficient_name(c.index)},
       {"fleet", effects_json(c.fleet)},
       {"user", JsonFields{{{"unit", c.unit}, {"size", c.size}, {"spread", c.fleet.spread / c.size}, {"measurement", c.fleet.measurement / c.size}}}},
       {"control_limits", std::vector{c.fleet.mean - c.control, c.fleet.mean + c.control}},
       {"run_rules", rules_json(c, f)}}};
  if (c.capability)
    out.fields.push_back({"capability", JsonFields{{{"target", c.capability->target},
                                                    {"limit", c.capability->limit},
                                                    {"cp", c.capability->cp},
                                                    {"cp_interval", std::vector{c.capability->cp_low, c.capability->cp_high}},
                                                    {"cpk", c.capability->cpk},
                                                    {"outside", c.capability->outside}}}});
  if (!c.drift.units.empty()) {
    JsonFields drift{{{"units", c.drift.units.size()}, {"repeatability", c.drift.repeatability}, {"repeatability_p_value", c.drift.p_value}}};
    if (c.mean_drift) drift.fields.push_back({"per_year", effects_json(*c.mean_drift)});
    out.fields.push_back({"drift", std::move(drift)});
  }
  if (c.stations) out.fields.push_back({"stations", gauge_json(*c.stations, f.sample.stations)});
  if (c.operators) out.fields.push_back({"operators", gauge_json(*c.operators, f.sample.operators)});
  return out;
}

}  // namespace

std::string left_out_text(const FleetStatistics& f) { return fmt::format("{}", fmt::join(left_out_names(f), ", ")); }

std::string due_text(const UnitDue& due) {
  return std::isfinite(due.time) ? time_text(due.time).substr(0, 10) : fmt::format("not in {:g} years", due_horizon);
}

std::string fleet_statistics_json(const FleetStatistics& f) {
  std::vector<JsonFields> coefficients, outliers, drifts, correlations, due;
  for (const CoefficientStatistics& c : f.coefficients) coefficients.push_back(coefficient_json(c, f));
  for (const FleetOutlier& o : f.search.outliers)
    outliers.push_back(
        {{{"unit", outlier_name(f, o)},
          {"distance", o.distance},
          {"coefficients", o.coefficients},
          {"p_value", o.p_value},
          {"farthest", coefficient_name(f.sample.coefficients[static_cast<std::size_t>(f.sample.common[static_cast<std::size_t>(o.worst)])])},
          {"sigmas", o.worst_sigmas}}});
  for (const SignificantDrift& d : f.drifts) {
    JsonFields one = drift_json(d.drift, f.sample.units[static_cast<std::size_t>(d.drift.unit)]);
    one.fields.insert(one.fields.begin() + 1, {"coefficient", coefficient_name(d.index)});
    drifts.push_back(std::move(one));
  }
  for (const SignificantCorrelation& c : f.correlations)
    correlations.push_back({{{"a", coefficient_name(c.a)}, {"b", coefficient_name(c.b)}, {"correlation", c.correlation}}});
  for (const UnitDue& d : f.due)
    due.push_back({{{"unit", f.sample.units[static_cast<std::size_t>(d.unit)]},
                    {"coefficient", coefficient_name(d.coefficient)},
                    {"time", std::isfinite(d.time) ? time_text(d.time) : ""}}});
  return fields_json({{{"units", f.sample.units.size()},
                       {"calibrations", f.sample.calibration.size()},
                       {"false_alarm", f.search.false_alarm},
                       {"coefficients", coefficients},
                       {"left_out", left_out_names(f)},
                       {"outliers_tested", f.search.possible},
                       {"outliers", outliers},
                       {"drifts", drifts},
                       {"due", due},
                       {"correlations", correlations}}});
}

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
      text += fmt::format(" {} {}", names[k].empty() ? "(none)" : names[k],
                          text::to_digits_of(0.25 * (g.levels[k].high - g.levels[k].low) / c.size, g.levels[k].bias / c.size));
  return text::wrapped(fmt::format("  {:<21} {}: ", coefficient(c.index).name, what), fmt::format("{} {} from their mean", text, c.unit));
}

std::string rule_text(const CoefficientStatistics& c, const FleetStatistics& f) {
  std::string text;
  const auto n = static_cast<double>(c.rows.size());
  for (std::size_t k = 0; k < run_rule_count; ++k) {
    const double expected = run_rules()[k].false_alarm * n, found = static_cast<double>(c.chart.fired[k].size());
    const double cluster = k == 0 ? 1 : 3;  // a run fires at several units, one after the other
    if (found <= expected + 4 * std::sqrt(cluster * expected) + cluster) continue;
    text += text::wrapped(fmt::format("  {:<21} ", coefficient(c.index).name),
                          fmt::format("{}: at {} units, {} expected; the first is {}", run_rules()[k].name, found, text::number(expected, 2),
                                      f.sample.unit_of_row(c.rows[static_cast<std::size_t>(c.chart.fired[k].front())])));
  }
  return text;
}

std::string headed(const std::string& heading, const std::string& body) { return body.empty() ? "" : "\n" + heading + "\n" + body; }

}  // namespace

std::string fleet_statistics_text(const FleetStatistics& f) {
  std::string text = fmt::format("{} units, {} calibrations; each unit's last one counts{}\n\n", f.sample.units.size(), f.sample.calibration.size(),
                                 f.search.outliers.empty() ? "" : ", outliers apart");
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
                         fmt::format("{}, for {}", f.sample.units[static_cast<std::size_t>(f.due[k].unit)], coefficient_name(f.due[k].coefficient)));
  for (std::size_t k = 0; k < std::min(most, f.search.outliers.size()); ++k) {
    const FleetOutlier& o = f.search.outliers[k];
    outliers += text::wrapped(
        fmt::format("  {}: ", outlier_name(f, o)),
        fmt::format("distance {} in {} coefficients; {} is {:+.1f} standard deviations from the mean", text::number(o.distance), o.coefficients,
                    coefficient_name(f.sample.coefficients[static_cast<std::size_t>(f.sample.common[static_cast<std::size_t>(o.worst)])]),
                    o.worst_sigmas));
  }
  for (std::size_t k = 0; k < std::min(most, f.drifts.size()); ++k) {
    const SignificantDrift& d = f.drifts[k];
    const auto c = std::find_if(f.coefficients.begin(), f.coefficients.end(), [&](const auto& x) { return x.index == d.index; });
    const double half = 0.5 * (d.drift.high - d.drift.low) / c->size;
    drift +=
        text::wrapped(fmt::format("  {}: ", f.sample.units[static_cast<std::size_t>(d.drift.unit)]),
                      fmt::format("{} {} +/- {} {} per year over {} years", coefficient_name(d.index),
                                  text::to_digits_of(half, d.drift.slope / c->size), text::two_digits(half), c->unit, text::number(d.drift.span, 2)));
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
