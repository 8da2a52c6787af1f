#include "imulab/fleet/statistics/outliers.hpp"

#include "imulab/core/decomposition.hpp"
#include "imulab/core/parallel.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/fleet.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
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

/// Mean and scatter in pieces of so many units, each by itself and added up in their order: the same on any number of threads, and little memory.
constexpr Eigen::Index units_per_piece = 4096;

/// The units that count among those of a piece, as columns.
Eigen::MatrixXd inside_piece(const OutlierInput& input, const Inside& inside, std::size_t piece) {
  const Eigen::Index begin = static_cast<Eigen::Index>(piece) * units_per_piece, end = std::min(begin + units_per_piece, input.values.rows());
  std::vector<Eigen::Index> rows;
  for (Eigen::Index i = begin; i < end; ++i)
    if (inside[static_cast<std::size_t>(i)] != 0) rows.push_back(i);
  return input.values(rows, Eigen::all).transpose();
}

FleetModel estimate(const OutlierInput& input, const Inside& inside) {
  const Eigen::Index p = input.values.cols();
  FleetModel f{static_cast<double>(std::count(inside.begin(), inside.end(), 1)), Eigen::VectorXd::Zero(p), Eigen::MatrixXd::Zero(p, p),
               Eigen::MatrixXd::Zero(p, p)};
  if (f.units < 2) return f;
  const auto pieces = static_cast<std::size_t>((input.values.rows() + units_per_piece - 1) / units_per_piece);
  std::vector<Eigen::VectorXd> sums(pieces);
  parallel_for(pieces, [&](std::size_t k) { sums[k] = inside_piece(input, inside, k).rowwise().sum(); });
  for (const Eigen::VectorXd& sum : sums) f.mean += sum;
  f.mean /= f.units;
  std::vector<Eigen::MatrixXd> scatters(pieces);
  parallel_for(pieces, [&](std::size_t k) {
    Eigen::MatrixXd z = inside_piece(input, inside, k);
    z.colwise() -= f.mean;
    scatters[k] = z * z.transpose();
  });
  for (const Eigen::MatrixXd& scatter : scatters) f.sample += scatter;
  f.sample /= f.units - 1;
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

/// The coefficients that a unit has.
std::vector<Eigen::Index> there_in(const OutlierInput& input, Eigen::Index unit) {
  std::vector<Eigen::Index> there;
  for (Eigen::Index j = 0; j < input.values.cols(); ++j)
    if (std::isfinite(input.values(unit, j))) there.push_back(j);
  return there;
}

/// A unit by the coefficients that it has, with the covariance of its measurement.
FleetOutlier judge(const OutlierInput& input, const FleetModel& all, Eigen::Index unit, bool inside, const Eigen::MatrixXd& covariance) {
  const std::vector<Eigen::Index> there = there_in(input, unit);
  const auto p = static_cast<Eigen::Index>(there.size());
  FleetOutlier out{.unit = unit, .coefficients = static_cast<int>(p)};
  if (p == 0) return out;
  const FleetModel fleet = inside ? without(all, input, unit) : all;
  const Eigen::MatrixXd variance = (covariance + fleet.spread)(there, there);
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

// Of a large fleet most units are surely none, which is found without the eigenvalues of each fleet less one unit: first by the spread alone, then
// with the unit's own covariance C and what it changes in mean and spread itself. With z from the mean of n units, V = C + spread and q = z^T V^-1 z,
//
//   without the unit  z' = n / (n - 1) z,  V' = V - b z z^T,  b = n / ((n - 1)(n - 2)),  z'^T V'^-1 z' = (n / (n - 1))^2 q / (1 - b q)
//
// (Sherman and Morrison 1950, doi:10.1214/aoms/1177729893). V' leaves out that the remaining spread grows by 1/(n - 2) of the sample's covariance,
// and that it is cut at zero anew: both are small beside the margin of `surely`, and who is not surely inside is judged as in a small fleet.
constexpr double few = 1000;    // up to so many a unit changes the estimate, and each is judged without itself
constexpr double surely = 0.7;  // of the squared limit: less than the limit of a unit that is measured worse than others, whose is smaller

/// Squared distances in the spread alone, which are never less than those with the measurement's covariance: who is near by these is near. NaN where
/// a coefficient is missing.
Eigen::ArrayXd upper_bounds(const OutlierInput& input, const FleetModel& fleet) {
  if (!fleet.whole || fleet.units < few) return Eigen::ArrayXd::Constant(input.values.rows(), std::numeric_limits<double>::quiet_NaN());
  const Cholesky factor(fleet.spread);
  if (!factor.positive_definite()) return Eigen::ArrayXd::Constant(input.values.rows(), std::numeric_limits<double>::quiet_NaN());
  Eigen::ArrayXd out(input.values.rows());
  constexpr Eigen::Index block = 256;
  const Eigen::MatrixXd whiten = factor.solve_lower(Eigen::MatrixXd(Eigen::MatrixXd::Identity(fleet.spread.rows(), fleet.spread.rows())));
  parallel_for(static_cast<std::size_t>((out.size() + block - 1) / block), [&](std::size_t k) {
    const Eigen::Index begin = static_cast<Eigen::Index>(k) * block, n = std::min(block, out.size() - begin);
    const Eigen::MatrixXd offsets = (input.values.middleRows(begin, n).rowwise() - fleet.mean.transpose()).transpose();
    out.segment(begin, n) = (whiten * offsets).colwise().squaredNorm().transpose().array();
  });
  return out;
}

/// The squared distance q from the fleet without the unit, nearly (above); infinite where it is not known.
double nearly_square(double q, double n, bool inside) {
  const double larger = n / (n - 1), b = larger / (n - 2);
  if (!inside) return q;
  return b * q < 1 ? larger * larger * q / (1 - b * q) : std::numeric_limits<double>::infinity();
}

/// The largest eigenvalue of V^-1 M is at most this, and equal to it where all are the same (Wolkowicz and Styan 1980,
/// doi:10.1016/0024-3795(80)90258-X): by the mean of the eigenvalues and their scatter. `v`, `m`: lower factors; in pieces of columns, which are zero
/// above the diagonal.
double most_eigenvalue(const Eigen::MatrixXd& v, const Eigen::MatrixXd& m) {
  constexpr Eigen::Index piece = 14;
  const Eigen::Index p = v.rows();
  Eigen::MatrixXd lower = Eigen::MatrixXd::Zero(p, p);  // half of A A^T, A = v^-1 m
  for (Eigen::Index begin = 0; begin < p; begin += piece) {
    const Eigen::Index rows = p - begin;
    const Cholesky factor = Cholesky::of_lower(v.bottomRightCorner(rows, rows));
    const Eigen::MatrixXd a = factor.solve_lower(Eigen::MatrixXd(m.block(begin, begin, rows, std::min(piece, rows))));
    lower.bottomRightCorner(rows, rows).selfadjointView<Eigen::Lower>().rankUpdate(a);
  }
  const auto n = static_cast<double>(p);
  const double mean = lower.trace() / n, squares = 2 * lower.squaredNorm() - lower.diagonal().squaredNorm();
  return mean + std::sqrt((n - 1) * std::max(0.0, squares / n - mean * mean));
}

/// Of one unit, with V = C + spread and M = mean covariance + spread: `square`, q or more than that, infinite where it is not known; `share`, no more
/// than the least eigenvalue of M^-1 V, and than 1.
struct UnitBound {
  double square = std::numeric_limits<double>::infinity(), share = 0;
};

/// `average`: the factor of M.
UnitBound unit_bound(const OutlierInput& input, const FleetModel& fleet, const Cholesky& average, Eigen::Index unit,
                     const Eigen::MatrixXd& covariance) {
  const std::vector<Eigen::Index> there = there_in(input, unit);
  const bool complete = std::ssize(there) == input.values.cols();
  const Eigen::MatrixXd sum = covariance + fleet.spread;
  const Cholesky factor(complete ? sum : Eigen::MatrixXd(sum(there, there)));
  UnitBound out;
  if (!factor.positive_definite()) return out;
  const Eigen::VectorXd z = (input.values.row(unit).transpose() - fleet.mean)(there);
  out.square = factor.solve_lower(z).squaredNorm();
  if (complete && average.positive_definite()) out.share = std::min(1.0, 1 / most_eigenvalue(factor.lower(), average.lower()));
  return out;
}

/// What is known of each unit from the rounds before: the bounds in `fleet`. NaN where nothing is known.
struct Screened {
  FleetModel fleet;
  Eigen::ArrayXd square, share;
};

/// The bounds in the fleet of a new estimate. With e the largest eigenvalue of M^-1 (old spread - new spread), at least 0, old V >= share old M
/// becomes V >= (share - (1 - share) e) M; with this share, old V <= (1 + e / share) V, and the mean has moved by |d|_M / sqrt(share) at most.
void take_to(Screened& screened, const FleetModel& fleet, const Cholesky& average) {
  if (screened.fleet.units == 0 || !average.positive_definite()) {
    screened.square.setConstant(std::numeric_limits<double>::quiet_NaN());
  } else {
    const Eigen::MatrixXd half = average.solve_lower(Eigen::MatrixXd(screened.fleet.spread - fleet.spread));
    const double e = std::max(0.0, symmetric_eigenvalues(average.solve_lower(Eigen::MatrixXd(half.transpose()))).maxCoeff());
    const double moved = average.solve_lower(Eigen::VectorXd(screened.fleet.mean - fleet.mean)).norm();
    screened.share -= (1 - screened.share) * e;
    const Eigen::ArrayXd grown = ((screened.square * (1 + e / screened.share)).sqrt() + moved / screened.share.sqrt()).square();
    screened.square = (screened.share > 0).select(grown, std::numeric_limits<double>::quiet_NaN());
  }
  screened.fleet = fleet;
}

/// The outliers of one round, in the order of the units. `screened`: of the round before, then of this one.
std::vector<FleetOutlier> outliers_of(const OutlierInput& input, const FleetModel& fleet, const Inside& inside, double level, Screened& screened) {
  const auto p = static_cast<std::size_t>(input.values.cols());
  std::vector<double> near(p + 1, 0);  // surely inside, by the number of coefficients
  const bool many = fleet.units >= few;
  for (std::size_t k = 1; k <= p && many; ++k) near[k] = surely * limit_of(level, static_cast<double>(k), fleet.units);
  const auto belongs = [&](Eigen::Index unit) { return inside[static_cast<std::size_t>(unit)] != 0; };
  const auto is_near = [&](double square, Eigen::Index unit, std::size_t has) {
    return many && nearly_square(square, fleet.units, belongs(unit)) <= near[has];
  };
  const Cholesky average(input.mean_covariance + fleet.spread);
  const Eigen::ArrayXd bounds = upper_bounds(input, fleet);
  take_to(screened, fleet, average);
  std::vector<Eigen::Index> open;
  for (Eigen::Index i = 0; i < input.values.rows(); ++i)
    if (!is_near(bounds[i], i, p) && !is_near(screened.square[i], i, p)) open.push_back(i);
  std::vector<FleetOutlier> out;
  constexpr std::size_t block = 512, task = 8;  // covariances in memory, twice; units of one call of a thread
  std::vector<Eigen::MatrixXd> covariances, following;
  const auto read_from = [&](std::size_t begin) {
    following.clear();
    for (std::size_t k = begin; k < std::min(begin + block, open.size()); ++k) following.push_back(input.covariance(open[k]));
  };
  read_from(0);
  for (std::size_t begin = 0; begin < open.size(); begin += block) {
    covariances.swap(following);
    const std::size_t n = covariances.size();
    std::vector<FleetOutlier> judged(n);
    parallel_for(1 + (n + task - 1) / task, [&](std::size_t t) {  // one of the calls reads meanwhile
      if (t == 0) return read_from(begin + block);
      for (std::size_t k = (t - 1) * task; k < std::min(n, t * task); ++k) {
        const Eigen::Index unit = open[begin + k];
        const auto has = static_cast<std::size_t>(input.values.row(unit).array().isFinite().count());
        if (has == 0) continue;
        if (many) {
          const UnitBound bound = unit_bound(input, fleet, average, unit, covariances[k]);
          screened.square[unit] = has == p ? bound.square : std::numeric_limits<double>::quiet_NaN();
          screened.share[unit] = bound.share;
          if (is_near(bound.square, unit, has)) continue;
        }
        judged[k] = judge(input, fleet, unit, belongs(unit), covariances[k]);
      }
    });
    std::copy_if(judged.begin(), judged.end(), std::back_inserter(out), [&](const FleetOutlier& o) { return o.p_value < level; });
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
  Inside inside = start_of(input.values, false_alarm), complete(inside.size());
  for (std::size_t i = 0; i < complete.size(); ++i) complete[i] = input.values.row(static_cast<Eigen::Index>(i)).allFinite();
  Screened screened{.fleet = {}, .square = Eigen::ArrayXd(input.values.rows()), .share = Eigen::ArrayXd::Ones(input.values.rows())};
  constexpr int rounds = 20;
  for (int round = 0; round < rounds; ++round) {
    const FleetModel fleet = estimate(input, inside);
    out.outliers.clear();
    out.mean = fleet.mean, out.spread = fleet.spread;
    out.possible = fleet.units > p + 3;
    if (!out.possible) return out;
    out.outliers = outliers_of(input, fleet, inside, level, screened);
    Inside next = complete;
    for (const FleetOutlier& o : out.outliers) next[static_cast<std::size_t>(o.unit)] = 0;
    if (next == inside) break;
    inside = std::move(next);
  }
  std::stable_sort(out.outliers.begin(), out.outliers.end(), [](const FleetOutlier& a, const FleetOutlier& b) { return a.distance > b.distance; });
  return out;
}

}  // namespace imulab
