#include "imulab/fleet/statistics/statistics.hpp"

#include "imulab/core/parallel.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/error.hpp"
#include "imulab/fleet.hpp"
#include "imulab/model/relative_uncertainty.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace imulab {

namespace {

OutlierSearch search_of(const FleetSample& s, const std::function<Eigen::MatrixXd(Eigen::Index row)>& covariance, double false_alarm) {
  OutlierInput input;
  input.values = s.values(s.last, s.common);
  input.mean_covariance = s.mean_covariance;
  input.covariance = [&](Eigen::Index unit) { return covariance(s.last[static_cast<std::size_t>(unit)]); };
  return find_outliers(input, false_alarm);
}

/// Rows of one column that have it.
struct FleetColumn {
  std::vector<Eigen::Index> rows;
  Eigen::ArrayXd values, variances;
  Eigen::ArrayXd constant, drawn_anew;  ///< parts of the variances: the same in each calibration of a unit, and the rest
};
FleetColumn column_of(const FleetSample& s, Eigen::Index column, const std::vector<Eigen::Index>& rows) {
  FleetColumn c;
  for (const Eigen::Index row : rows)
    if (!std::isnan(s.values(row, column))) c.rows.push_back(row);
  c.values = s.values.col(column)(c.rows);
  c.variances = s.variances.col(column)(c.rows);
  c.constant = Eigen::ArrayXd::Zero(c.values.size());
  if (s.constant_variances.size() > 0) {
    const auto unit_of = [&](Eigen::Index row) { return s.unit[static_cast<std::size_t>(row)]; };
    Eigen::ArrayXd shared =
        Eigen::ArrayXd::Constant(std::ranges::max(s.unit) + 1, std::numeric_limits<double>::infinity());  // the least of a unit's calibrations
    for (const Eigen::Index row : c.rows) shared[unit_of(row)] = std::min(shared[unit_of(row)], s.constant_variances(row, column));
    for (std::size_t k = 0; k < c.rows.size(); ++k) c.constant[static_cast<Eigen::Index>(k)] = shared[unit_of(c.rows[k])];
  }
  constexpr double least = 1e-6;  // of a variance is drawn anew: the prior alone would be no measurement
  c.drawn_anew = (c.variances - c.constant).max(least * c.variances);
  return c;
}

std::vector<Eigen::Index> all_rows(const FleetSample& s) {
  std::vector<Eigen::Index> rows(static_cast<std::size_t>(s.time.size()));
  for (std::size_t k = 0; k < rows.size(); ++k) rows[k] = static_cast<Eigen::Index>(k);
  return rows;
}

std::optional<Gauge> gauge_of(const FleetSample& s, const FleetColumn& c, const std::vector<Eigen::Index>& level, std::size_t levels,
                              double confidence) {
  if (levels < 2) return std::nullopt;
  GaugeInput in{{}, {}, static_cast<Eigen::Index>(levels), c.values, c.drawn_anew};
  for (const Eigen::Index row : c.rows) {
    in.unit.push_back(s.unit[static_cast<std::size_t>(row)]);
    in.level.push_back(level[static_cast<std::size_t>(row)]);
  }
  return compare_levels(in, confidence);
}

void take_drift(CoefficientStatistics& out, const FleetSample& s, const FleetColumn& c, double confidence) {
  if (s.last.size() == static_cast<std::size_t>(s.time.size())) return;  // every unit was calibrated once
  DriftInput in{{}, s.time(c.rows) / unit::year, c.values, c.drawn_anew};
  for (const Eigen::Index row : c.rows) in.unit.push_back(s.unit[static_cast<std::size_t>(row)]);
  out.drift = fleet_drift(in, confidence);
  if (out.drift.units.size() < 2) return;
  const auto n = static_cast<Eigen::Index>(out.drift.units.size());
  Eigen::ArrayXd slopes(n), variances(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const UnitDrift& u = out.drift.units[static_cast<std::size_t>(k)];
    slopes[k] = u.slope, variances[k] = u.uncertainty * u.uncertainty;
  }
  out.mean_drift = random_effects(slopes, variances, confidence);
}

/// When each unit is due for this coefficient.
void take_due(CoefficientStatistics& out, const FleetSample& s, const FleetColumn& last, const std::vector<Requirement>& errors, double scale) {
  double limit = std::numeric_limits<double>::infinity();
  for (const Requirement& r : errors)
    if (contains(r.coefficients, out.index)) limit = std::min(limit, r.limit * (coefficient(out.index).term == Term::matrix ? scale : 1));
  if (!out.mean_drift || std::isinf(limit)) return;
  const Slope fleet = slopes_of(*out.mean_drift);
  std::vector<const UnitDrift*> own(s.units.size());
  for (const UnitDrift& u : out.drift.units) own[static_cast<std::size_t>(u.unit)] = &u;
  for (std::size_t k = 0; k < last.rows.size(); ++k) {
    const Eigen::Index unit = s.unit[static_cast<std::size_t>(last.rows[k])], row = static_cast<Eigen::Index>(k);
    const double repeatability = out.drift.repeatability;
    Slope slope = fleet;
    Aging aging{.level_sigma = std::hypot(std::sqrt(last.variances[row]), repeatability), .repeatability = repeatability};
    if (const UnitDrift* line = own[static_cast<std::size_t>(unit)]) {
      slope = slope_among(fleet, {line->slope, line->uncertainty * line->uncertainty});
      aging.level = line->level - last.values[row], aging.level_sigma = std::hypot(line->level_uncertainty, std::sqrt(last.constant[row])),
      aging.since_middle = line->since_middle;
    }
    aging.slope = slope.mean, aging.slope_sigma = std::sqrt(slope.variance);
    out.due.push_back({unit, out.index, s.time[last.rows[k]] + unit::year * years_until(aging, limit)});
  }
}

/// The mean scale of a matrix element's row; 1 where the fleet has none.
double row_scale(const FleetSample& s, const std::vector<Eigen::Index>& rows, const Coefficient& c) {
  if (c.term != Term::matrix) return 1;
  const CoefficientIndex diagonal = coefficient_index(c.triad, Term::matrix, c.row, c.row);
  const auto found = std::find(s.coefficients.begin(), s.coefficients.end(), diagonal);
  if (found == s.coefficients.end()) return 1;
  const FleetColumn column = column_of(s, found - s.coefficients.begin(), rows);
  return column.values.size() > 0 ? std::abs(column.values.mean()) : 1;
}

void take_units(CoefficientStatistics& out, double scale) {
  const Coefficient& c = coefficient(out.index);
  const double largest = std::max(std::abs(c.term == Term::offset ? out.fleet.mean : 0.0), out.fleet.spread + out.fleet.measurement);
  if (user_units(c).empty()) {
    out.unit = std::string(c.unit);
    return;
  }
  const UserUnit unit = user_unit(c, c.term == Term::matrix ? largest / scale : largest);
  out.unit = std::string(unit.name);
  out.size = unit.size * (c.term == Term::matrix ? scale : 1);
}

void take_capability(CoefficientStatistics& out, const std::vector<Requirement>& requirements, double scale) {
  const Coefficient& c = coefficient(out.index);
  for (const Requirement& r : requirements) {
    if (!contains(r.coefficients, out.index)) continue;
    const bool diagonal = is_scale(c), of_one = scale > 0.5 && scale < 2;  // readings in SI have scales of about one
    const double target = !diagonal ? 0 : of_one ? std::copysign(1.0, out.fleet.mean) : out.fleet.mean;
    out.capability = capability(out.fleet, target, r.limit * (c.term == Term::matrix ? scale : 1));
  }
}

CoefficientStatistics statistics_of(const FleetSample& s, Eigen::Index column, const std::vector<Eigen::Index>& rows, const FleetOptions& o) {
  CoefficientStatistics out;
  out.index = s.coefficients[static_cast<std::size_t>(column)];
  const Coefficient& c = coefficient(out.index);
  const FleetColumn good = column_of(s, column, rows), last = column_of(s, column, s.last), all = column_of(s, column, all_rows(s));
  const FleetColumn& counted = good.values.size() > 0 ? good : last;
  if (counted.values.size() == 0) return out;  // older calibrations alone had it
  out.fleet = random_effects(counted.values, counted.variances, o.confidence);
  out.rows = last.rows;
  out.chart = control_chart(last.values, last.variances, out.fleet);
  out.control = 3 * std::hypot(out.fleet.spread, out.fleet.measurement);
  const double scale = row_scale(s, counted.rows, c);
  take_units(out, scale);
  take_capability(out, o.requirements, scale);
  take_drift(out, s, all, o.confidence);
  take_due(out, s, last, o.errors, scale);
  out.stations = gauge_of(s, all, s.station, s.stations.size(), o.confidence);
  out.operators = gauge_of(s, all, s.operated_by, s.operators.size(), o.confidence);
  return out;
}

/// Correlations between units, and those that chance does not explain: of T = S - C, whose elements have the errors of S.
void take_correlations(FleetStatistics& f, double level) {
  if (!f.search.possible) return;
  const Eigen::Index p = f.search.spread.rows();
  const Eigen::VectorXd size = f.search.spread.diagonal().cwiseSqrt();
  const Eigen::MatrixXd sample = f.search.spread + f.sample.mean_covariance;
  const double n = static_cast<double>(f.sample.last.size() - f.search.outliers.size()),
               pairs = std::max(1.0, 0.5 * static_cast<double>(p * (p - 1)));
  const double limit = student_quantile(1 - 0.5 * level / pairs, n - 1);
  f.correlation = Eigen::MatrixXd::Identity(p, p);
  for (Eigen::Index i = 0; i < p; ++i)
    for (Eigen::Index j = 0; j < i; ++j) {
      if (!(size[i] > 0 && size[j] > 0)) continue;
      f.correlation(i, j) = f.correlation(j, i) = f.search.spread(i, j) / (size[i] * size[j]);
      const double error = std::sqrt((sample(i, i) * sample(j, j) + sample(i, j) * sample(i, j)) / (n - 1));
      if (std::abs(f.search.spread(i, j)) > limit * error) {
        const auto name = [&](Eigen::Index k) {
          return f.sample.coefficients[static_cast<std::size_t>(f.sample.common[static_cast<std::size_t>(k)])];
        };
        f.correlations.push_back({name(j), name(i), f.correlation(i, j)});
      }
    }
  std::stable_sort(f.correlations.begin(), f.correlations.end(),
                   [](const auto& a, const auto& b) { return std::abs(a.correlation) > std::abs(b.correlation); });
}

void take_significant_drifts(FleetStatistics& f, double false_alarm) {
  double tests = 0;
  for (const CoefficientStatistics& c : f.coefficients) tests += static_cast<double>(c.drift.units.size());
  for (const CoefficientStatistics& c : f.coefficients)
    for (const UnitDrift& u : c.drift.units)
      if (u.p_value < false_alarm / tests) f.drifts.push_back({c.index, u});
  std::stable_sort(f.drifts.begin(), f.drifts.end(), [](const auto& a, const auto& b) { return a.drift.p_value < b.drift.p_value; });
}

/// Each unit's first date.
void take_first_due(FleetStatistics& f) {
  std::vector<std::optional<UnitDue>> first(f.sample.units.size());
  for (const CoefficientStatistics& c : f.coefficients)
    for (const UnitDue& d : c.due)
      if (std::optional<UnitDue>& at = first[static_cast<std::size_t>(d.unit)]; !at || d.time < at->time) at = d;
  for (const std::optional<UnitDue>& d : first)
    if (d) f.due.push_back(*d);
  std::stable_sort(f.due.begin(), f.due.end(), [](const UnitDue& a, const UnitDue& b) { return a.time < b.time; });
}

}  // namespace

namespace {

void check(const FleetSample& s, const FleetOptions& options) {
  std::vector<std::string> problems;
  for (const auto& [name, level] : {std::pair{"confidence", options.confidence}, std::pair{"false_alarm", options.false_alarm}})
    if (!(level > 0 && level < 1)) problems.push_back(fmt::format("{}: {} is no probability; expected more than 0 and less than 1", name, level));
  for (const std::vector<Requirement>* limits : {&options.requirements, &options.errors})
    for (const Requirement& r : *limits)
      for (const std::string& problem : problems_of(r)) problems.push_back(problem);
  const Eigen::Index rows = s.time.size(), columns = std::ssize(s.coefficients);
  const bool rows_agree = std::ssize(s.unit) == rows && std::ssize(s.station) == rows && std::ssize(s.operated_by) == rows;
  if (!rows_agree || s.values.rows() != rows || s.variances.rows() != rows || s.values.cols() != columns || s.variances.cols() != columns ||
      (s.constant_variances.size() > 0 && (s.constant_variances.rows() != rows || s.constant_variances.cols() != columns)))
    problems.emplace_back("the sample's tables have different sizes; expected a row a calibration and a column a coefficient");
  throw_problems("the fleet", problems);
}

}  // namespace

FleetStatistics fleet_statistics(FleetSample sample, const std::function<Eigen::MatrixXd(Eigen::Index row)>& covariance,
                                 const FleetOptions& options) {
  check(sample, options);
  FleetStatistics f;
  f.sample = std::move(sample);
  f.search = search_of(f.sample, covariance, options.false_alarm);
  std::vector<char> out(f.sample.last.size());
  for (const FleetOutlier& o : f.search.outliers) out[static_cast<std::size_t>(o.unit)] = 1;
  std::vector<Eigen::Index> rows;
  for (std::size_t k = 0; k < out.size(); ++k)
    if (out[k] == 0) rows.push_back(f.sample.last[k]);
  f.coefficients.resize(f.sample.coefficients.size());
  parallel_for(f.coefficients.size(),
               [&](std::size_t column) { f.coefficients[column] = statistics_of(f.sample, static_cast<Eigen::Index>(column), rows, options); });
  std::erase_if(f.coefficients, [](const CoefficientStatistics& c) { return c.rows.empty(); });
  take_correlations(f, options.false_alarm);
  take_significant_drifts(f, options.false_alarm);
  take_first_due(f);
  return f;
}

}  // namespace imulab
