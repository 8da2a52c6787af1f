#include "imulab/fleet/statistics/outliers.hpp"

#include "imulab/core/decomposition.hpp"
#include "imulab/core/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace imulab {

namespace {

using Inside = std::vector<char>;  // of the fleet's estimate, by unit

/// Far from the median in any coefficient alone: the start. Units without all coefficients do not enter the estimate.
Inside start_of(const Eigen::MatrixXd& values, double level) {
  Inside inside(static_cast<std::size_t>(values.rows()), 1);
  const double limit = normal_quantile(1 - 0.5 * level / static_cast<double>(values.size()));
  for (Eigen::Index j = 0; j < values.cols(); ++j) {
    std::vector<double> column;
    for (const double value : values.col(j))
      if (std::isfinite(value)) column.push_back(value);
    const double center = median(column), sigma = robust_sigma(column);
    for (Eigen::Index i = 0; i < values.rows(); ++i)
      if (!(std::abs(values(i, j) - center) <= limit * sigma)) inside[static_cast<std::size_t>(i)] = 0;
  }
  return inside;
}

struct FleetModel {
  double units = 0;
  Eigen::VectorXd mean;
  Eigen::MatrixXd sample, spread;  ///< covariance of the values; between units
  bool whole = false;              ///< the spread is positive definite by itself
};

/// The sample's covariance less the measurement's, no direction below zero.
void take_spread(FleetModel& f, const Eigen::MatrixXd& measurement) {
  // In units of each coefficient's own size, so that what is no spread is told from rounding. One that is the same in all units has that of its
  // uncertainty.
  const Eigen::VectorXd size = f.sample.diagonal().cwiseMax(measurement.diagonal()).cwiseSqrt();
  const Eigen::MatrixXd sizes = size * size.transpose();
  SymmetricEigen e = symmetric_eigen(Eigen::MatrixXd((f.sample - measurement).array() / sizes.array()));
  f.whole = e.values.minCoeff() > 1e-3;
  e.values = e.values.cwiseMax(0);
  f.spread = (e.vectors * e.values.asDiagonal() * e.vectors.transpose()).array() * sizes.array();
}

FleetModel estimate(const OutlierInput& input, const Inside& inside) {
  const Eigen::Index p = input.values.cols();
  FleetModel f{0, Eigen::VectorXd::Zero(p), Eigen::MatrixXd::Zero(p, p), Eigen::MatrixXd::Zero(p, p)};
  Eigen::MatrixXd kept(p, static_cast<Eigen::Index>(std::count(inside.begin(), inside.end(), 1)));
  for (Eigen::Index i = 0, k = 0; i < input.values.rows(); ++i)
    if (inside[static_cast<std::size_t>(i)] != 0) kept.col(k++) = input.values.row(i).transpose();
  f.units = static_cast<double>(kept.cols());
  if (f.units < 2) return f;
  f.mean = kept.rowwise().mean();
  kept.colwise() -= f.mean;
  f.sample = kept * kept.transpose() / (f.units - 1);
  take_spread(f, input.mean_covariance);
  return f;
}

/// The estimate without one of its units.
FleetModel without(const FleetModel& all, const OutlierInput& input, Eigen::Index unit) {
  const double n = all.units;
  const Eigen::VectorXd z = input.values.row(unit).transpose() - all.mean;
  FleetModel f{n - 1, all.mean - z / (n - 1), ((n - 1) * all.sample - n / (n - 1) * z * z.transpose()) / (n - 2), {}};
  take_spread(f, input.mean_covariance);
  return f;
}

/// P of a unit that belongs to a fleet that was estimated without it: Hotelling's T^2. `relative`: the unit's variance, spread and measurement, over
/// the average unit's, whose errors the estimate of the spread has; its degrees of freedom are those of Satterthwaite.
double probability(double square, double p, double n, double relative) {
  const double freedom = std::max(p + 1, (n - 1) * relative * relative);
  return f_tail(square / (1 + 1 / (n * relative)) * (freedom - p + 1) / (freedom * p), p, freedom - p + 1);
}

/// The squared distance that has this probability.
double limit_of(double level, double p, double n) {
  double low = 0, high = 1e6;
  for (int k = 0; k < 80; ++k) (probability(0.5 * (low + high), p, n, 1) > level ? low : high) = 0.5 * (low + high);
  return low;
}

/// A unit by the coefficients that it has.
FleetOutlier judge(const OutlierInput& input, const FleetModel& all, Eigen::Index unit, bool inside) {
  std::vector<Eigen::Index> there;
  for (Eigen::Index j = 0; j < input.values.cols(); ++j)
    if (std::isfinite(input.values(unit, j))) there.push_back(j);
  const auto p = static_cast<Eigen::Index>(there.size());
  FleetOutlier out{.unit = unit, .coefficients = static_cast<int>(p)};
  if (p == 0) return out;
  const FleetModel fleet = inside ? without(all, input, unit) : all;
  const Eigen::MatrixXd variance = (input.covariance(unit) + fleet.spread)(there, there);
  const Eigen::MatrixXd average = (input.mean_covariance + fleet.spread)(there, there);
  const Eigen::VectorXd offset = (input.values.row(unit).transpose() - fleet.mean)(there);
  const double square = squared_norm_in(variance, offset);
  const double relative = solve_semidefinite(average, variance).trace() / static_cast<double>(p);
  out.distance = std::sqrt(square);
  out.p_value = probability(square, static_cast<double>(p), fleet.units, relative);
  Eigen::Index worst = 0;
  (offset.array().square() / variance.diagonal().array()).maxCoeff(&worst);
  out.worst = there[static_cast<std::size_t>(worst)];
  out.worst_sigmas = offset[worst] / std::sqrt(variance(worst, worst));
  return out;
}

/// Squared distances in the spread alone, which are never less than those with the measurement's covariance: who is near by these is near. NaN where
/// a coefficient is missing.
Eigen::ArrayXd upper_bounds(const OutlierInput& input, const FleetModel& fleet) {
  constexpr double few = 1000;  // then a unit changes the estimate, and each is judged without itself
  if (!fleet.whole || fleet.units < few) return Eigen::ArrayXd::Constant(input.values.rows(), std::numeric_limits<double>::quiet_NaN());
  const Cholesky factor(fleet.spread);
  if (!factor.positive_definite()) return Eigen::ArrayXd::Constant(input.values.rows(), std::numeric_limits<double>::quiet_NaN());
  Eigen::ArrayXd out(input.values.rows());
  constexpr Eigen::Index block = 256;
  const Eigen::MatrixXd whiten = factor.solve_lower(Eigen::MatrixXd(Eigen::MatrixXd::Identity(fleet.spread.rows(), fleet.spread.rows())));
  for (Eigen::Index begin = 0; begin < out.size(); begin += block) {
    const Eigen::Index n = std::min(block, out.size() - begin);
    const Eigen::MatrixXd offsets = (input.values.middleRows(begin, n).rowwise() - fleet.mean.transpose()).transpose();
    out.segment(begin, n) = (whiten * offsets).colwise().squaredNorm().transpose().array();
  }
  return out;
}

}  // namespace

OutlierSearch find_outliers(const OutlierInput& input, double false_alarm) {
  OutlierSearch out;
  out.false_alarm = false_alarm;
  if (input.values.size() == 0) return out;
  const auto p = static_cast<double>(input.values.cols());
  const double level = false_alarm / std::max<double>(1, static_cast<double>(input.values.rows()));
  Inside inside = start_of(input.values, false_alarm);
  constexpr int rounds = 20;
  for (int round = 0; round < rounds; ++round) {
    const FleetModel fleet = estimate(input, inside);
    out.outliers.clear();
    out.mean = fleet.mean, out.spread = fleet.spread;
    out.possible = fleet.units > p + 3;
    if (!out.possible) return out;
    const Eigen::ArrayXd bounds = upper_bounds(input, fleet);
    const double surely_inside = 0.7 * limit_of(level, p, fleet.units);  // less than the limit of a unit that is measured better than others
    Inside next(inside.size(), 1);
    for (Eigen::Index i = 0; i < input.values.rows(); ++i) {
      const auto k = static_cast<std::size_t>(i);
      const bool complete = input.values.row(i).allFinite();
      next[k] = complete;
      if (bounds[i] <= surely_inside) continue;
      const FleetOutlier o = judge(input, fleet, i, inside[k] != 0);
      if (o.p_value >= level) continue;
      next[k] = 0;
      out.outliers.push_back(o);
    }
    if (next == inside) break;
    inside = std::move(next);
  }
  std::stable_sort(out.outliers.begin(), out.outliers.end(), [](const FleetOutlier& a, const FleetOutlier& b) { return a.distance > b.distance; });
  return out;
}

}  // namespace imulab
