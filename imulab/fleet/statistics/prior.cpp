#include "imulab/fleet/statistics/prior.hpp"

#include "imulab/core/decomposition.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/error.hpp"
#include "imulab/fleet.hpp"
#include "imulab/fleet/statistics/outliers.hpp"
#include "imulab/frame.hpp"
#include "imulab/model/effects.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <tuple>
#include <utility>

namespace imulab {

namespace {

using Eigen::Index;
using Places = std::vector<Index>;

constexpr double implausible = 1e-3;  // probability of a unit of the fleet

Index place_in(const std::vector<CoefficientIndex>& all, CoefficientIndex index) {
  const auto found = std::find(all.begin(), all.end(), index);
  return found == all.end() ? -1 : found - all.begin();
}

/// The prior's coefficients in a calibration: places of the estimated ones, there and in the prior, and those not determined.
struct Matched {
  Places in_calibration, in_prior, open;
};
Matched matched(const std::vector<CoefficientIndex>& estimated, const FleetPrior& prior) {
  Matched m;
  for (std::size_t k = 0; k < prior.coefficients.size(); ++k) {
    const Index at = place_in(estimated, prior.coefficients[k]), own = static_cast<Index>(k);
    if (at < 0) {
      m.open.push_back(own);
    } else {
      m.in_calibration.push_back(at);
      m.in_prior.push_back(own);
    }
  }
  return m;
}

/// Values x with covariance P and the prior m, C of the elements `at`: one observation more.
///   K = P_:a (P_aa + C)^-1,  x += K (m - x_a),  P -= K P_a:
void observe(Eigen::VectorXd& x, Eigen::MatrixXd& P, const Places& at, const Eigen::VectorXd& mean, const Eigen::MatrixXd& covariance) {
  // In units of the prior's own sigmas: coefficients differ by many powers of ten.
  const Eigen::VectorXd size = covariance.diagonal().cwiseSqrt();
  const Eigen::MatrixXd across = size.cwiseInverse().asDiagonal() * P(at, Eigen::all);
  const Eigen::MatrixXd sum = size.cwiseInverse().asDiagonal() * (P(at, at) + covariance) * size.cwiseInverse().asDiagonal();
  const Eigen::MatrixXd gain = solve_semidefinite(sum, across).transpose();
  x += gain * ((mean - x(at)).array() / size.array()).matrix();
  P -= gain * across;
  P = (0.5 * (P + P.transpose())).eval();
}

/// The coefficients not determined, by the prior given the others: m_o + B (x - m_e), B = C_oe C_ee^-1, with the covariance that those then have.
void fill(Eigen::VectorXd& x, Eigen::MatrixXd& P, const Matched& m, const FleetPrior& prior) {
  const Eigen::VectorXd size = prior.covariance.diagonal().cwiseSqrt();
  const Eigen::MatrixXd C = size.cwiseInverse().asDiagonal() * prior.covariance * size.cwiseInverse().asDiagonal();
  const Eigen::MatrixXd B = size(m.open).asDiagonal() *
                            solve_semidefinite(C(m.in_prior, m.in_prior), Eigen::MatrixXd(C(m.in_prior, m.open))).transpose() *
                            size(m.in_prior).cwiseInverse().asDiagonal();
  const Index known = x.size(), more = std::ssize(m.open);
  const Eigen::VectorXd values = prior.mean(m.open) + B * (x(m.in_calibration) - prior.mean(m.in_prior));
  const Eigen::MatrixXd cross = B * P(m.in_calibration, Eigen::all);
  const Eigen::MatrixXd own =
      prior.covariance(m.open, m.open) - B * prior.covariance(m.in_prior, m.open) + B * P(m.in_calibration, m.in_calibration) * B.transpose();
  x.conservativeResize(known + more);
  x.tail(more) = values;
  P.conservativeResize(known + more, known + more);
  P.bottomLeftCorner(more, known) = cross;
  P.topRightCorner(known, more) = cross.transpose();
  P.bottomRightCorner(more, more) = 0.5 * (own + own.transpose());
}

/// The factor of a term over temperature in the size of its effect, whose second and third order are as large as the first at 50 K.
double per_size(const Coefficient& c, const SensorModel& model) {
  const int order = c.term == Term::thermal ? c.column : c.term == Term::matrix_thermal1 ? 1 : 2;
  return std::pow(second_order_per_first, order - 1) * (c.term == Term::thermal ? std::abs(triad_model(model, c.triad).matrix(c.row, c.row))
                                                                                : 1 / MatrixThermal{c.row, c.column, order, false}.size());
}

std::string effect_of(const Coefficient& c) {
  return fmt::format("{}.{}", to_string(c.triad), is_matrix_thermal(c.term) ? "matrix_thermal" : "thermal");
}

/// Root mean squares of the terms over temperature in the last calibrations of these units: of each effect that order, of scales or misalignments,
/// with the largest. A value is nearer to zero than the truth by the prior of its own calibration; values and variances together are as large.
std::map<std::string, double, std::less<>> sizes_over_temperature(const FleetSample& s, const std::vector<bool>& outlier, std::ptrdiff_t enough,
                                                                  const SensorModel& mean) {
  struct Sum {
    double squares = 0;
    std::ptrdiff_t values = 0;
  };
  std::map<std::tuple<std::string, int, bool>, Sum> sums;
  for (std::size_t k = 0; k < s.coefficients.size(); ++k) {
    const Coefficient& c = coefficient(s.coefficients[k]);
    if (!is_thermal(c.term)) continue;
    const int order = c.term == Term::thermal ? c.column : c.term == Term::matrix_thermal1 ? 1 : 2;
    const double factor = per_size(c, mean);
    Sum& sum = sums[{effect_of(c), order, is_matrix_thermal(c.term) && c.row != c.column}];
    for (std::size_t unit = 0; unit < s.last.size(); ++unit) {
      const auto column = static_cast<Index>(k);
      const double value = s.values(s.last[unit], column);
      if (outlier[unit] || !std::isfinite(value)) continue;
      sum.squares += factor * factor * (value * value + s.variances(s.last[unit], column)), ++sum.values;
    }
  }
  std::map<std::string, double, std::less<>> out;
  for (const auto& [of, sum] : sums)
    if (sum.values >= enough) {
      double& size = out[std::get<0>(of)];
      size = std::max(size, std::sqrt(sum.squares / static_cast<double>(sum.values)));
    }
  return out;
}

}  // namespace

FleetPrior fleet_prior(const FleetSample& s, const std::function<Eigen::MatrixXd(Eigen::Index row)>& covariance) {
  FleetPrior out;
  Places columns, among_common;
  for (std::size_t k = 0; k < s.common.size(); ++k) {
    const CoefficientIndex index = s.coefficients[static_cast<std::size_t>(s.common[k])];
    if (const Term term = coefficient(index).term; term != Term::offset && term != Term::matrix) continue;
    out.coefficients.push_back(index);
    columns.push_back(s.common[k]);
    among_common.push_back(static_cast<Index>(k));
  }
  if (columns.empty()) throw Error("most units' calibrations have no bias and no matrix in common; expected some, for a prior of them");
  OutlierInput input{.values = s.values(s.last, columns), .mean_covariance = s.mean_covariance(among_common, among_common), .covariance = {}};
  input.covariance = [&](Index unit) -> Eigen::MatrixXd { return covariance(s.last[static_cast<std::size_t>(unit)])(among_common, among_common); };
  constexpr double false_alarm = 0.01, enough = 6;  // units more than coefficients: then the factor is known to a half
  const OutlierSearch search = find_outliers(input, false_alarm);
  std::vector<bool> outlier(s.last.size());
  for (const FleetOutlier& o : search.outliers) outlier[static_cast<std::size_t>(o.unit)] = true;
  for (Index unit = 0; unit < input.values.rows(); ++unit)
    if (!outlier[static_cast<std::size_t>(unit)] && input.values.row(unit).allFinite()) out.units += 1;
  const double n = out.units;
  const auto p = static_cast<double>(columns.size());
  if (!search.possible || n < p + enough)
    throw Error(
        fmt::format("{:.0f} units that belong together are too few for a prior of {:.0f} coefficients; expected at least {:.0f}", n, p, p + enough));
  out.mean = search.mean;
  out.covariance = (1 + 1 / n) * (n - 1) / (n - p - 2) * (search.spread + input.mean_covariance);
  SensorModel mean;
  for (Index k = 0; k < out.mean.size(); ++k) set_coefficient(mean, out.coefficients[static_cast<std::size_t>(k)], out.mean[k]);
  out.effect_sigmas = sizes_over_temperature(s, outlier, static_cast<std::ptrdiff_t>(enough), mean);
  return out;
}

Session with_sizes(Session session, const FleetPrior& prior) {
  const auto is_raw = [](const std::optional<ThermalSource>& sensor) { return sensor && sensor->unit == "raw"; };
  for (const RecordingSource& source : session.recordings)
    if (is_raw(source.accel_temperature) || is_raw(source.gyro_temperature)) return session;
  session.imu.effect_sigmas.insert(prior.effect_sigmas.begin(), prior.effect_sigmas.end());
  return session;
}

PriorUse fit_of_sizes(const Calibration& c, const FleetPrior& prior) {
  Places at;
  std::vector<double> sizes;
  for (std::size_t k = 0; k < c.estimated.size(); ++k) {
    const Coefficient& of = coefficient(c.estimated[k]);
    if (!is_thermal(of.term) || !prior.effect_sigmas.contains(effect_of(of))) continue;
    at.push_back(static_cast<Index>(k));
    sizes.push_back(prior.effect_sigmas.at(effect_of(of)) / per_size(of, c.model));
  }
  PriorUse use;
  if (at.empty()) return use;
  const Eigen::VectorXd size = Eigen::Map<const Eigen::VectorXd>(sizes.data(), std::ssize(sizes)), x = coefficient_values(c.model, c.estimated)(at);
  const Eigen::MatrixXd in_sizes = size.cwiseInverse().asDiagonal() * c.covariance(at, at) * size.cwiseInverse().asDiagonal();
  const double square =
      squared_norm_in(Eigen::MatrixXd(in_sizes + Eigen::MatrixXd::Identity(size.size(), size.size())), Eigen::VectorXd(x.cwiseQuotient(size)));
  use.distance = std::sqrt(square), use.p_value = chi_square_tail(square, static_cast<double>(at.size()));
  use.taken = use.p_value >= implausible;
  return use;
}

PriorUse take_prior(Calibration& calibration, const FleetPrior& prior) {
  const SensorModel& given = calibration.model;
  if (given.accel.raw_unit != prior.accel_unit || given.gyro.raw_unit != prior.gyro_unit)
    throw Error(fmt::format("{}: its units give readings in {} and {}, this one in {} and {}; expected one kind of unit", prior.fleet,
                            prior.accel_unit, prior.gyro_unit, given.accel.raw_unit, given.gyro.raw_unit));
  PriorUse use;
  Calibration c = in_accelerometer_frame(calibration);
  Eigen::VectorXd x = coefficient_values(c.model, c.estimated);
  const Matched m = matched(c.estimated, prior);
  if (m.in_prior.empty())
    throw Error(fmt::format("{}: the calibration estimates no bias and no matrix that its units have; expected some", prior.fleet));
  const Eigen::MatrixXd own = prior.covariance(m.in_prior, m.in_prior);
  const double square = squared_norm_in(Eigen::MatrixXd(c.covariance(m.in_calibration, m.in_calibration) + own),
                                        Eigen::VectorXd(x(m.in_calibration) - prior.mean(m.in_prior)));
  use.distance = std::sqrt(square);
  use.p_value = chi_square_tail(square, static_cast<double>(m.in_prior.size()));
  if (!(use.p_value >= implausible)) return use;
  use.taken = true;
  c.constant_covariance.resize(0, 0);  // what the unit brings again is no longer known beside the fleet's part
  observe(x, c.covariance, m.in_calibration, prior.mean(m.in_prior), own);
  if (!m.open.empty()) fill(x, c.covariance, m, prior);
  for (const Index k : m.open) use.filled.push_back(prior.coefficients[static_cast<std::size_t>(k)]);
  c.estimated.insert(c.estimated.end(), use.filled.begin(), use.filled.end());
  for (std::size_t k = 0; k < c.estimated.size(); ++k) set_coefficient(c.model, c.estimated[k], x[static_cast<Index>(k)]);
  calibration = std::move(c);
  return use;
}

double relative_sigma(const FleetPrior& prior, CoefficientIndex index) {
  const Index at = place_in(prior.coefficients, index);
  if (at < 0) return std::numeric_limits<double>::infinity();
  const Coefficient& c = coefficient(index);
  const double sigma = std::sqrt(prior.covariance(at, at));
  if (c.term != Term::matrix) return sigma;
  const Index scale = place_in(prior.coefficients, coefficient_index(c.triad, Term::matrix, c.row, c.row));
  return scale < 0 ? std::numeric_limits<double>::infinity() : sigma / std::abs(prior.mean[scale]);
}

std::vector<Requirement> left_to_reach(const std::vector<Requirement>& requirements, const FleetPrior& prior) {
  std::vector<Requirement> left;
  for (const Requirement& r : requirements)
    for (const CoefficientIndex index : r.coefficients) {
      const double sigma = relative_sigma(prior, index);
      if (sigma <= r.limit) continue;
      Requirement alone = r;
      alone.coefficients = {index};
      const double part = r.limit / sigma;  // zero without a prior
      alone.limit = r.limit / std::sqrt(1 - part * part);
      left.push_back(std::move(alone));
    }
  return left;
}

}  // namespace imulab
