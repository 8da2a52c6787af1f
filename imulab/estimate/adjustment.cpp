#include "imulab/estimate/adjustment.hpp"

#include "imulab/core/statistics.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <cmath>

namespace imulab {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Rows divided by the Cholesky factor of their block-tridiagonal covariance: unit, uncorrelated noise.
MatrixXd whitened(const Conditions& conditions, const MatrixXd& rows) {
  MatrixXd white(rows.rows(), rows.cols());
  MatrixXd previous_factor;
  Index previous_first = 0, previous_size = 0;
  for (const Conditions::Block& block : conditions.blocks) {
    MatrixXd own = block.covariance;
    MatrixXd right = rows.middleRows(block.first, block.size);
    if (block.coupling.size() > 0) {
      const MatrixXd coupled = previous_factor.triangularView<Eigen::Lower>().solve(block.coupling.transpose()).transpose();
      own -= coupled * coupled.transpose();
      right -= coupled * white.middleRows(previous_first, previous_size);
    }
    previous_factor = own.llt().matrixL();
    white.middleRows(block.first, block.size) = previous_factor.triangularView<Eigen::Lower>().solve(right);
    previous_first = block.first;
    previous_size = block.size;
  }
  return white;
}

double covariance_between(const Conditions& conditions, Index a, Index b) {
  if (a < b) std::swap(a, b);
  for (std::size_t k = 0; k < conditions.blocks.size(); ++k) {
    const Conditions::Block& block = conditions.blocks[k];
    if (a < block.first || a >= block.first + block.size) continue;
    if (b >= block.first) return block.covariance(a - block.first, b - block.first);
    if (k > 0 && block.coupling.size() > 0 && b >= conditions.blocks[k - 1].first) return block.coupling(a - block.first, b - conditions.blocks[k - 1].first);
  }
  return 0;
}

}  // namespace

Adjustment adjust(const Conditions& conditions, const VectorXd& prior_sigma) {
  const Index n = prior_sigma.size();
  MatrixXd joined(conditions.value.size(), n + 1);
  joined << conditions.jacobian * prior_sigma.asDiagonal(), conditions.value;
  const MatrixXd white = whitened(conditions, joined);
  const MatrixXd normal = white.leftCols(n).transpose() * white.leftCols(n);  // in units of the prior sigmas
  const VectorXd right = -white.leftCols(n).transpose() * white.col(n);

  Adjustment result;
  // Undetermined: data and prior together know it no better than half its prior sigma.
  const VectorXd posterior = (normal + MatrixXd::Identity(n, n)).llt().solve(MatrixXd::Identity(n, n)).diagonal();
  std::vector<Index> known, unknown;
  for (Index i = 0; i < n; ++i) (posterior[i] < 0.25 ? known : unknown).push_back(i);
  result.determined.assign(static_cast<std::size_t>(n), 0);
  for (const Index i : known) result.determined[static_cast<std::size_t>(i)] = 1;

  result.correction = VectorXd::Zero(n);
  result.covariance = MatrixXd::Zero(n, n);
  if (!known.empty()) {
    const MatrixXd n_kk = normal(known, known);
    const VectorXd diagonal = n_kk.diagonal().cwiseSqrt().cwiseInverse();
    const Eigen::SelfAdjointEigenSolver<MatrixXd> spectrum(diagonal.asDiagonal() * n_kk * diagonal.asDiagonal());
    result.condition = std::sqrt(spectrum.eigenvalues().maxCoeff() / std::max(spectrum.eigenvalues().minCoeff(), 1e-300));
    const Eigen::LLT<MatrixXd> factor(n_kk);
    MatrixXd p_kk = factor.solve(MatrixXd::Identity(n_kk.rows(), n_kk.cols()));
    const VectorXd step = p_kk * right(known);
    if (!unknown.empty()) {  // the parameters left at their starting values are uncertain by their prior sigma
      const MatrixXd leak = p_kk * normal(known, unknown);
      p_kk += leak * leak.transpose();
    }
    for (std::size_t i = 0; i < known.size(); ++i) {
      result.correction[known[i]] = step[static_cast<Index>(i)] * prior_sigma[known[i]];
      for (std::size_t j = 0; j < known.size(); ++j)
        result.covariance(known[i], known[j]) = p_kk(static_cast<Index>(i), static_cast<Index>(j)) * prior_sigma[known[i]] * prior_sigma[known[j]];
    }
  }
  result.residual = conditions.value + conditions.jacobian * result.correction;
  result.residual_variance = conditions.variance - (conditions.jacobian * result.covariance).cwiseProduct(conditions.jacobian).rowwise().sum();
  result.residual_variance = result.residual_variance.cwiseMax(1e-9 * conditions.variance);
  result.chi2 = (white.col(n) + white.leftCols(n) * result.correction.cwiseQuotient(prior_sigma)).squaredNorm();
  result.degrees_of_freedom = static_cast<int>(conditions.value.size()) - static_cast<int>(known.size());
  return result;
}

double estimate_spread(const Conditions& conditions, const Adjustment& adjustment, ConditionKind kind, double current) {
  struct Row {
    double square, variance, gain, redundancy;  // expected square = (variance + x gain) redundancy, variance without spread
  };
  std::vector<Row> rows;
  double degrees = 0;
  for (Index i = 0; i < conditions.value.size(); ++i) {
    if (conditions.kind[static_cast<std::size_t>(i)] != kind) continue;
    const double redundancy = adjustment.residual_variance[i] / conditions.variance[i];
    if (redundancy < 1e-3) continue;  // the fit follows this row: it says nothing of the spread
    const double gain = conditions.spread_gain[i];
    const double sampling = std::max(conditions.variance[i] - current * current * gain, 1e-12 * conditions.variance[i]);
    rows.push_back({adjustment.residual[i] * adjustment.residual[i], sampling, gain, redundancy});
    degrees += redundancy;
  }
  if (rows.size() < 3 || degrees < 1) return 0;
  const auto excess = [&](double x) {  // observed over expected squares, 1 where the spread is right; falls with x
    double sum = 0;
    for (const Row& row : rows) sum += row.square / ((row.variance + x * row.gain) * row.redundancy);
    return sum / static_cast<double>(rows.size());
  };
  if (chi_square_tail(excess(0) * degrees, degrees) > 0.01) return 0;
  double low = 0, high = 0;
  for (const Row& row : rows) high = std::max(high, row.square / (row.gain * row.redundancy));
  high *= 10;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (excess(middle) > 1 ? low : high) = middle;
  }
  return std::sqrt(0.5 * (low + high));
}

double outlier_log_probability(const Conditions& conditions, const Adjustment& adjustment, const std::vector<Index>& rows) {
  if (rows.empty()) return 0;
  const auto n = static_cast<Index>(rows.size());
  MatrixXd expected(n, n);
  for (Index a = 0; a < n; ++a)
    for (Index b = 0; b < n; ++b) expected(a, b) = covariance_between(conditions, rows[static_cast<std::size_t>(a)], rows[static_cast<std::size_t>(b)]);
  const VectorXd scale = expected.diagonal().cwiseSqrt().cwiseInverse();
  const MatrixXd j = conditions.jacobian(rows, Eigen::all);
  expected -= j * adjustment.covariance * j.transpose();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> spectrum(scale.asDiagonal() * expected * scale.asDiagonal());
  const VectorXd projected = spectrum.eigenvectors().transpose() * scale.cwiseProduct(adjustment.residual(rows));
  double statistic = 0, degrees = 0;
  for (Index i = 0; i < n; ++i) {
    if (spectrum.eigenvalues()[i] < 1e-6) continue;  // the adjustment follows this combination whatever its value
    statistic += projected[i] * projected[i] / spectrum.eigenvalues()[i];
    degrees += 1;
  }
  if (degrees == 0) return 0;
  return log_chi_square_tail(statistic, degrees);
}

KindFit fit_of(const Conditions& conditions, const Adjustment& adjustment, ConditionKind kind) {
  KindFit fit;
  double chi2 = 0, squares = 0, rows = 0;
  for (Index i = 0; i < conditions.value.size(); ++i) {
    if (conditions.kind[static_cast<std::size_t>(i)] != kind) continue;
    const double square = adjustment.residual[i] * adjustment.residual[i];
    chi2 += square / adjustment.residual_variance[i];
    squares += square;
    fit.degrees_of_freedom += adjustment.residual_variance[i] / conditions.variance[i];
    rows += 1;
  }
  if (rows > 0) {
    fit.chi2_per_dof = chi2 / rows;
    fit.rms = std::sqrt(squares / rows);
  }
  return fit;
}

}  // namespace imulab
