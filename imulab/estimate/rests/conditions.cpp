#include "imulab/estimate/rests/conditions.hpp"

#include "imulab/core/statistics.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>

namespace imulab::rests {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Rows divided by the Cholesky factor of their block-tridiagonal covariance: unit, uncorrelated noise.
MatrixXd whitened(const Conditions& conditions, const MatrixXd& rows) {
  MatrixXd white(rows.rows(), rows.cols());
  MatrixXd factor;  // of the block before
  Index first = 0, size = 0;
  for (const Conditions::Block& block : conditions.blocks) {
    MatrixXd own = block.covariance;
    MatrixXd right = rows.middleRows(block.first, block.size);
    if (block.coupling.size() > 0) {
      const MatrixXd coupled = factor.triangularView<Eigen::Lower>().solve(block.coupling.transpose()).transpose();
      own -= coupled * coupled.transpose();
      right -= coupled * white.middleRows(first, size);
    }
    factor = own.llt().matrixL();
    first = block.first, size = block.size;
    white.middleRows(first, size) = factor.triangularView<Eigen::Lower>().solve(right);
  }
  return white;
}

double covariance_between(const Conditions& conditions, Index a, Index b) {
  if (a < b) std::swap(a, b);
  for (std::size_t k = 0; k < conditions.blocks.size(); ++k) {
    const Conditions::Block& block = conditions.blocks[k];
    if (a < block.first || a >= block.first + block.size) continue;
    if (b >= block.first) return block.covariance(a - block.first, b - block.first);
    if (block.coupling.size() > 0 && b >= conditions.blocks[k - 1].first)
      return block.coupling(a - block.first, b - conditions.blocks[k - 1].first);
  }
  return 0;
}

/// Residuals of one kind against their size: square / ((sampling + x) redundancy) is 1 on average where x is the square of the spread.
class KindResiduals {
 public:
  KindResiduals(const Conditions& conditions, const Adjustment& adjustment, Kind kind, double current_spread) {
    for (Index i = 0; i < conditions.value.size(); ++i) {
      if (conditions.kind[static_cast<std::size_t>(i)] != kind) continue;
      const double variance = adjustment.variance[i], redundancy = adjustment.residual_variance[i] / variance;
      if (redundancy < 1e-3) continue;  // the fit follows this row: it says nothing of the spread
      const double sampling = std::max(variance - current_spread * current_spread, 1e-12 * variance);
      rows_.push_back({adjustment.residual[i] * adjustment.residual[i], sampling, redundancy});
      degrees_ += redundancy;
    }
  }
  bool enough() const { return rows_.size() >= 3 && degrees_ >= 1; }
  double degrees() const { return degrees_; }
  double excess(double x) const {
    double sum = 0;
    for (const Row& row : rows_) sum += row.square / ((row.sampling + x) * row.redundancy);
    return sum / static_cast<double>(rows_.size());
  }
  double upper_bound() const {
    double high = 0;
    for (const Row& row : rows_) high = std::max(high, row.square / row.redundancy);
    return 10 * high;
  }

 private:
  struct Row {
    double square, sampling, redundancy;
  };
  std::vector<Row> rows_;
  double degrees_ = 0;
};

}  // namespace

VectorXd Conditions::variance() const {
  VectorXd out(value.size());
  for (const Block& block : blocks) out.segment(block.first, block.size) = block.covariance.diagonal();
  return out;
}

kernel::Information Conditions::information() const {
  MatrixXd joined(value.size(), jacobian.cols() + 1);
  joined << jacobian, value;
  const MatrixXd white = whitened(*this, joined);
  return {white.leftCols(jacobian.cols()), white.col(jacobian.cols())};
}

Adjustment adjust(const Conditions& conditions, kernel::Parameters parameters) {
  std::replace(parameters.role.begin(), parameters.role.end(), kernel::Role::considered, kernel::Role::fixed);
  Adjustment out{kernel::solve(conditions.information(), parameters, "the rests"), {}, conditions.variance(), {}};
  out.residual = conditions.value + conditions.jacobian * out.solution.x;
  const VectorXd fitted = (conditions.jacobian * out.solution.covariance).cwiseProduct(conditions.jacobian).rowwise().sum();
  out.residual_variance = (out.variance - fitted).cwiseMax(1e-9 * out.variance);  // rounding, where the fit follows a row
  return out;
}

double redundancy(const Conditions& conditions, const Adjustment& adjustment, Kind kind) {
  double sum = 0;
  for (Index i = 0; i < conditions.value.size(); ++i)
    if (conditions.kind[static_cast<std::size_t>(i)] == kind) sum += adjustment.residual_variance[i] / adjustment.variance[i];
  return sum;
}

bool spread_is_significant(const Conditions& conditions, const Adjustment& adjustment, Kind kind) {
  const KindResiduals residuals(conditions, adjustment, kind, 0);
  return residuals.enough() && chi_square_tail(residuals.excess(0) * residuals.degrees(), residuals.degrees()) < 0.01;
}

double estimate_spread(const Conditions& conditions, const Adjustment& adjustment, Kind kind, double current) {
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
  expected -= j * adjustment.solution.covariance * j.transpose();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> spectrum(scale.asDiagonal() * expected * scale.asDiagonal());
  const VectorXd projected = spectrum.eigenvectors().transpose() * scale.cwiseProduct(adjustment.residual(rows));
  for (Index i = 0; i < n; ++i) {
    if (spectrum.eigenvalues()[i] < 1e-6) continue;  // the adjustment follows this combination whatever its value
    deviation.statistic += projected[i] * projected[i] / spectrum.eigenvalues()[i];
    deviation.degrees_of_freedom += 1;
  }
  return deviation;
}

double Deviation::log_probability(double residual_degrees) const {
  if (degrees_of_freedom == 0) return 0;
  if (std::isinf(residual_degrees)) return log_chi_square_tail(statistic, degrees_of_freedom);
  return std::log(std::max(f_tail(statistic / degrees_of_freedom, degrees_of_freedom, residual_degrees), 1e-300));
}

}  // namespace imulab::rests
