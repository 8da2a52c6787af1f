#include "imulab/estimate/adjustment.hpp"

#include "imulab/core/error.hpp"
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
  const Index n = prior_sigma.size(), rows = conditions.value.size();
  MatrixXd joined(rows, n + 1);
  joined << conditions.jacobian * prior_sigma.asDiagonal(), conditions.value;  // in units of the prior sigmas
  const MatrixXd white = whitened(conditions, joined);
  const MatrixXd design = white.leftCols(n), normal = design.transpose() * design;

  Adjustment result;
  const VectorXd scale = normal.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> spectrum(scale.asDiagonal() * normal * scale.asDiagonal());
  result.condition = std::sqrt(spectrum.eigenvalues()[n - 1] / std::max(spectrum.eigenvalues()[0], 1e-300));
  const MatrixXd p = normal.llt().solve(MatrixXd::Identity(n, n));
  const VectorXd step = -p * (design.transpose() * white.col(n));
  if (!p.allFinite() || !step.allFinite()) throw Unsupported("the data are too poor for a fit: the normal equations cannot be solved; more rests in more directions are needed");
  result.determined.resize(static_cast<std::size_t>(n));
  for (Index i = 0; i < n; ++i) result.determined[static_cast<std::size_t>(i)] = p(i, i) < 0.25;
  result.correction = step.cwiseProduct(prior_sigma);
  result.covariance = prior_sigma.asDiagonal() * p * prior_sigma.asDiagonal();
  result.residual = conditions.value + conditions.jacobian * result.correction;
  result.residual_variance = conditions.variance - (conditions.jacobian * result.covariance).cwiseProduct(conditions.jacobian).rowwise().sum();
  result.residual_variance = result.residual_variance.cwiseMax(1e-9 * conditions.variance);  // rounding, where the fit follows a row
  const VectorXd white_residual = white.col(n) + design * step;
  const VectorXd kept = VectorXd::Ones(rows) - (design * p).cwiseProduct(design).rowwise().sum();
  for (Index i = 0; i < rows; ++i) {
    if (conditions.kind[static_cast<std::size_t>(i)] == ConditionKind::prior) continue;
    result.chi2 += white_residual[i] * white_residual[i];
    result.degrees_of_freedom += kept[i];
  }
  return result;
}

MatrixXd covariance_considering(const Conditions& conditions, const VectorXd& prior_sigma, const std::vector<char>& determined) {
  std::vector<Index> known, held;
  for (std::size_t i = 0; i < determined.size(); ++i) (determined[i] ? known : held).push_back(static_cast<Index>(i));
  const MatrixXd design = whitened(conditions, conditions.jacobian * prior_sigma.asDiagonal());
  const MatrixXd normal = design.transpose() * design;  // the held ones' own prior rows are on its diagonal alone
  MatrixXd p = MatrixXd::Identity(prior_sigma.size(), prior_sigma.size());
  if (!known.empty()) {
    const MatrixXd p_kk = MatrixXd(normal(known, known)).llt().solve(MatrixXd::Identity(static_cast<Index>(known.size()), static_cast<Index>(known.size())));
    const MatrixXd leak = p_kk * normal(known, held);
    p(known, known) = p_kk + leak * leak.transpose();
    p(known, held) = -leak;
    p(held, known) = -leak.transpose();
  }
  return prior_sigma.asDiagonal() * p * prior_sigma.asDiagonal();
}

namespace {

/// Residuals of one kind against their size: square / ((sampling + x gain) redundancy) is 1 on average where x is the square of the spread.
class KindResiduals {
 public:
  KindResiduals(const Conditions& conditions, const Adjustment& adjustment, ConditionKind kind, double current_spread) {
    for (Index i = 0; i < conditions.value.size(); ++i) {
      if (conditions.kind[static_cast<std::size_t>(i)] != kind) continue;
      const double redundancy = adjustment.residual_variance[i] / conditions.variance[i];
      if (redundancy < 1e-3) continue;  // the fit follows this row: it says nothing of the spread
      const double gain = conditions.spread_gain[i];
      const double sampling = std::max(conditions.variance[i] - current_spread * current_spread * gain, 1e-12 * conditions.variance[i]);
      rows_.push_back({adjustment.residual[i] * adjustment.residual[i], sampling, gain, redundancy});
      degrees_ += redundancy;
    }
  }
  bool enough() const { return rows_.size() >= 3 && degrees_ >= 1; }
  double degrees() const { return degrees_; }
  double excess(double x) const {
    double sum = 0;
    for (const Row& row : rows_) sum += row.square / ((row.sampling + x * row.gain) * row.redundancy);
    return sum / static_cast<double>(rows_.size());
  }
  double upper_bound() const {
    double high = 0;
    for (const Row& row : rows_) high = std::max(high, row.square / (row.gain * row.redundancy));
    return 10 * high;
  }

 private:
  struct Row {
    double square, sampling, gain, redundancy;
  };
  std::vector<Row> rows_;
  double degrees_ = 0;
};

}  // namespace

double redundancy(const Conditions& conditions, const Adjustment& adjustment, ConditionKind kind) {
  double sum = 0;
  for (Index i = 0; i < conditions.value.size(); ++i)
    if (conditions.kind[static_cast<std::size_t>(i)] == kind) sum += adjustment.residual_variance[i] / conditions.variance[i];
  return sum;
}

bool spread_is_significant(const Conditions& conditions, const Adjustment& adjustment, ConditionKind kind) {
  const KindResiduals residuals(conditions, adjustment, kind, 0);
  return residuals.enough() && chi_square_tail(residuals.excess(0) * residuals.degrees(), residuals.degrees()) < 0.01;
}

double estimate_spread(const Conditions& conditions, const Adjustment& adjustment, ConditionKind kind, double current) {
  const KindResiduals residuals(conditions, adjustment, kind, current);
  if (!residuals.enough() || residuals.excess(0) <= 1) return 0;
  double low = 0, high = residuals.upper_bound();
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (residuals.excess(middle) > 1 ? low : high) = middle;
  }
  return std::sqrt(0.5 * (low + high));
}

Deviation deviation_of(const Conditions& conditions, const Adjustment& adjustment, const std::vector<Index>& rows) {
  Deviation deviation;
  if (rows.empty()) return deviation;
  const auto n = static_cast<Index>(rows.size());
  MatrixXd expected(n, n);
  for (Index a = 0; a < n; ++a)
    for (Index b = 0; b < n; ++b) expected(a, b) = covariance_between(conditions, rows[static_cast<std::size_t>(a)], rows[static_cast<std::size_t>(b)]);
  const VectorXd scale = expected.diagonal().cwiseSqrt().cwiseInverse();
  const MatrixXd j = conditions.jacobian(rows, Eigen::all);
  expected -= j * adjustment.covariance * j.transpose();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> spectrum(scale.asDiagonal() * expected * scale.asDiagonal());
  const VectorXd projected = spectrum.eigenvectors().transpose() * scale.cwiseProduct(adjustment.residual(rows));
  for (Index i = 0; i < n; ++i) {
    if (spectrum.eigenvalues()[i] < 1e-6) continue;  // the adjustment follows this combination whatever its value
    deviation.statistic += projected[i] * projected[i] / spectrum.eigenvalues()[i];
    deviation.degrees_of_freedom += 1;
  }
  return deviation;
}

double Deviation::log_probability() const {
  if (degrees_of_freedom == 0) return 0;
  return log_chi_square_tail(statistic, degrees_of_freedom);
}

double Deviation::log_probability(double residual_degrees) const {
  if (degrees_of_freedom == 0) return 0;
  return std::log(std::max(f_tail(statistic / degrees_of_freedom, degrees_of_freedom, residual_degrees), 1e-300));
}

}  // namespace imulab
