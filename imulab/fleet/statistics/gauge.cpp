#include "imulab/fleet/statistics/gauge.hpp"

#include "imulab/core/decomposition.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/fleet.hpp"
#include "imulab/fleet/statistics/random_effects.hpp"

#include <algorithm>
#include <cmath>

namespace imulab {

namespace {

using ByUnit = std::vector<std::vector<Eigen::Index>>;

ByUnit rows_by_unit(const GaugeInput& in) {
  ByUnit out(in.unit.empty() ? 0 : static_cast<std::size_t>(*std::max_element(in.unit.begin(), in.unit.end())) + 1);
  for (std::size_t k = 0; k < in.unit.size(); ++k) out[static_cast<std::size_t>(in.unit[k])].push_back(static_cast<Eigen::Index>(k));
  std::erase_if(out, [](const auto& rows) { return rows.empty(); });
  return out;
}

/// Sums over the rows of a unit by level: only of levels that the unit has, so that its time grows with its rows.
class LevelSums {
 public:
  explicit LevelSums(Eigen::Index levels) : sum_(Eigen::VectorXd::Zero(levels)) {}
  void add(Eigen::Index level, double x) {
    if (sum_[level] == 0) levels_.push_back(level);
    sum_[level] += x;
  }
  /// Subtracts `factor` times the outer product of the sums, and begins anew.
  void subtract_square(double factor, Eigen::MatrixXd& from) {
    for (const Eigen::Index a : levels_)
      for (const Eigen::Index b : levels_) from(a, b) -= factor * sum_[a] * sum_[b];
    for (const Eigen::Index a : levels_) sum_[a] = 0;
    levels_.clear();
  }

 private:
  Eigen::VectorXd sum_;
  std::vector<Eigen::Index> levels_;
};

struct LevelFit {
  Eigen::VectorXd means;  ///< of the levels
  Eigen::MatrixXd covariance;
};

/// Means of the levels: a unit's block of V^-1 is D - D 1 1^T D / (1/spread2 + sum D), D = 1 / (v + repeat2).
LevelFit fit_levels(const GaugeInput& in, const ByUnit& units, double spread2, double repeat2) {
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(in.levels, in.levels);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(in.levels);
  LevelSums of_unit(in.levels);
  for (const auto& rows : units) {
    double sum = 0, weighted = 0;
    for (const Eigen::Index k : rows) {
      const double d = 1 / (in.variances[k] + repeat2);
      sum += d, weighted += d * in.values[k];
    }
    const double shared = spread2 > 0 ? 1 / (1 / spread2 + sum) : 0;
    for (const Eigen::Index k : rows) {
      const double d = 1 / (in.variances[k] + repeat2);
      const Eigen::Index a = in.level[static_cast<std::size_t>(k)];
      normal(a, a) += d;
      right[a] += d * (in.values[k] - shared * weighted);
      of_unit.add(a, d);
    }
    of_unit.subtract_square(shared, normal);
  }
  for (Eigen::Index a = 0; a < in.levels; ++a)
    if (normal(a, a) == 0) normal(a, a) = 1;  // without calibrations
  const Eigen::MatrixXd covariance = inverse_of(normal);
  return {covariance * right, covariance};
}

/// Residuals of one unit about its mean, weighted.
double squares_within(const GaugeInput& in, const ByUnit& units, const Eigen::ArrayXd& residual, double repeat2) {
  double sum = 0;
  for (const auto& rows : units) {
    double w = 0, wr = 0, wrr = 0;
    for (const Eigen::Index k : rows) {
      const double d = 1 / (in.variances[k] + repeat2);
      w += d, wr += d * residual[k], wrr += d * residual[k] * residual[k];
    }
    sum += wrr - wr * wr / w;
  }
  return sum;
}

/// Degrees of freedom within units, less the biases that are found there.
double freedom_within(const GaugeInput& in, const ByUnit& units) {
  double freedom = 0;
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(in.levels, in.levels);
  LevelSums of_unit(in.levels);
  for (const auto& rows : units) {
    freedom += static_cast<double>(rows.size()) - 1;
    for (const Eigen::Index k : rows) {
      const Eigen::Index a = in.level[static_cast<std::size_t>(k)];
      gram(a, a) += 1;
      of_unit.add(a, 1);
    }
    of_unit.subtract_square(1 / static_cast<double>(rows.size()), gram);
  }
  const Eigen::VectorXd values = symmetric_eigenvalues(gram);
  return freedom - static_cast<double>((values.array() > 1e-9 * std::max(1.0, values.maxCoeff())).count());
}

double repeat_variance(const GaugeInput& in, const ByUnit& units, const Eigen::ArrayXd& residual, double freedom) {
  if (!(freedom > 0) || squares_within(in, units, residual, 0) <= freedom) return 0;
  double low = 0, high = in.variances.maxCoeff();
  while (squares_within(in, units, residual, high) > freedom) high *= 4;
  for (int k = 0; k < 50; ++k) (squares_within(in, units, residual, 0.5 * (low + high)) > freedom ? low : high) = 0.5 * (low + high);
  return 0.5 * (low + high);
}

double unit_variance(const GaugeInput& in, const ByUnit& units, const Eigen::ArrayXd& residual, double repeat2) {
  Eigen::ArrayXd means(static_cast<Eigen::Index>(units.size())), variances(means.size());
  for (std::size_t i = 0; i < units.size(); ++i) {
    double w = 0, wr = 0;
    for (const Eigen::Index k : units[i]) {
      const double d = 1 / (in.variances[k] + repeat2);
      w += d, wr += d * residual[k];
    }
    means[static_cast<Eigen::Index>(i)] = wr / w, variances[static_cast<Eigen::Index>(i)] = 1 / w;
  }
  return random_spread2(means, variances);
}

}  // namespace

Gauge compare_levels(const GaugeInput& in, double confidence) {
  Gauge out;
  out.levels.resize(static_cast<std::size_t>(in.levels));
  for (const Eigen::Index level : in.level) out.levels[static_cast<std::size_t>(level)].calibrations += 1;
  const ByUnit units = rows_by_unit(in);
  std::vector<Eigen::Index> used;
  for (Eigen::Index a = 0; a < in.levels; ++a)
    if (out.levels[static_cast<std::size_t>(a)].calibrations > 0) used.push_back(a);
  for (const auto& rows : units)
    for (const Eigen::Index k : rows) out.units_shared |= in.level[static_cast<std::size_t>(k)] != in.level[static_cast<std::size_t>(rows[0])];
  const auto m = static_cast<Eigen::Index>(used.size());
  const double between = static_cast<double>(units.size()) - static_cast<double>(m), within = freedom_within(in, units);
  if (m < 2 || between < 1) return out;
  double spread2 = (in.values - in.values.mean()).square().mean(), repeat2 = 0;
  LevelFit fit;
  for (int k = 0; k < 20; ++k) {
    fit = fit_levels(in, units, spread2, repeat2);
    Eigen::ArrayXd residual(in.values.size());
    for (Eigen::Index i = 0; i < residual.size(); ++i) residual[i] = in.values[i] - fit.means[in.level[static_cast<std::size_t>(i)]];
    const double before_spread = spread2, before_repeat = repeat2;
    repeat2 = repeat_variance(in, units, residual, within);
    // The biases took their part of the differences between units: of n units n - m are left.
    spread2 = unit_variance(in, units, residual, repeat2) * (out.units_shared ? 1 : (between + static_cast<double>(m) - 1) / between);
    if (std::abs(spread2 - before_spread) <= 1e-6 * spread2 && std::abs(repeat2 - before_repeat) <= 1e-6 * repeat2) break;
  }
  fit = fit_levels(in, units, spread2, repeat2);
  out.repeatability = std::sqrt(repeat2), out.spread = std::sqrt(spread2);
  Eigen::MatrixXd center = Eigen::MatrixXd::Identity(m, m) - Eigen::MatrixXd::Constant(m, m, 1.0 / static_cast<double>(m));
  const Eigen::VectorXd bias = center * fit.means(used);
  const Eigen::MatrixXd covariance = center * fit.covariance(used, used) * center.transpose();
  const double freedom = out.units_shared && within > between ? within : between, factor = student_quantile(0.5 + 0.5 * confidence, freedom);
  for (Eigen::Index a = 0; a < m; ++a) {
    GaugeLevel& level = out.levels[static_cast<std::size_t>(used[static_cast<std::size_t>(a)])];
    const double half = factor * std::sqrt(covariance(a, a));
    level.bias = bias[a], level.low = bias[a] - half, level.high = bias[a] + half;
  }
  const auto df = static_cast<double>(m - 1);
  out.p_value = f_tail(squared_norm_in(covariance, bias) / df, df, freedom);
  out.reproducibility = std::sqrt(std::max(0.0, (bias.squaredNorm() - covariance.trace()) / df));
  return out;
}

}  // namespace imulab
