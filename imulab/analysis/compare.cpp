#include "imulab/analysis/compare.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/core/units.hpp"
#include "imulab/model/coefficient.hpp"
#include "imulab/model/frame.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>

namespace imulab {

namespace {

const Coefficient& row_of(int index) { return coefficient_table()[static_cast<std::size_t>(index)]; }

Eigen::VectorXd values(const SensorModel& model) {
  Eigen::VectorXd v(coefficient_count);
  for (int i = 0; i < coefficient_count; ++i) v(i) = coefficient_value(model, i);
  return v;
}

/// The covariance over the whole table, zero where nothing was estimated.
Eigen::MatrixXd table_covariance(const Calibration& c) {
  Eigen::MatrixXd p = Eigen::MatrixXd::Zero(coefficient_count, coefficient_count);
  p(c.estimated, c.estimated) = c.covariance;
  return p;
}

/// Differences of coefficients -> the same with the matrices' as D = (M_b - M_a) M_a^-1.
Eigen::MatrixXd to_relative(const SensorModel& a) {
  Eigen::MatrixXd t = Eigen::MatrixXd::Identity(coefficient_count, coefficient_count);
  for (const Triad triad : {Triad::accel, Triad::gyro}) {
    const Matrix3d& matrix = triad == Triad::accel ? a.accel.matrix : a.gyro.matrix;
    if (!(std::abs(matrix.determinant()) > 0)) throw Error(std::string(to_string(triad)) + ".matrix is singular");
    for (int row = 0; row < 3; ++row) {
      const int at = coefficient_index(triad, Term::matrix, row, 0);
      t.block<3, 3>(at, at) = matrix.inverse().transpose();
    }
  }
  return t;
}

struct UserUnit {
  std::string_view name;
  double size;  ///< SI
};

/// The unit a person reads this coefficient's differences in; `size` is the largest of its term [SI].
UserUnit user_unit(const Coefficient& c, double size) {
  switch (c.term) {
    case Term::offset:
      if (c.triad == Triad::accel) return size < 1e4 * unit::ug ? UserUnit{"ug", unit::ug} : UserUnit{"mg", 1e3 * unit::ug};
      return size < 1e4 * unit::deg_per_h ? UserUnit{"deg/h", unit::deg_per_h} : UserUnit{"deg/s", unit::deg};
    case Term::matrix:
      return c.row == c.column ? UserUnit{"ppm", unit::ppm} : UserUnit{"arcsec", unit::arcsec};
    case Term::g_sensitivity:
      return {"deg/h/g", unit::deg_per_h / unit::g};
    case Term::lever_arm:
      return {"mm", 1e-3};
    case Term::quadratic:
    case Term::cubic:
    case Term::thermal:
      break;
  }
  return {c.unit, 1};
}

/// Directions without variance (two coefficients that are one) cannot be tested and do not count.
Consistency consistency_of(const Eigen::VectorXd& e, const Eigen::MatrixXd& p) {
  if (e.size() == 0) return {};
  const Eigen::VectorXd sigma = p.diagonal().cwiseSqrt();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> correlation(sigma.cwiseInverse().asDiagonal() * p * sigma.cwiseInverse().asDiagonal());
  const Eigen::VectorXd whitened = correlation.eigenvectors().transpose() * e.cwiseQuotient(sigma);
  Consistency out;
  for (Eigen::Index i = 0; i < e.size(); ++i) {
    if (correlation.eigenvalues()(i) < 1e-12 * static_cast<double>(e.size())) continue;  // rounding of the correlations
    out.chi2 += whitened(i) * whitened(i) / correlation.eigenvalues()(i);
    ++out.degrees_of_freedom;
  }
  if (out.degrees_of_freedom > 0) out.p_value = chi_square_tail(out.chi2, out.degrees_of_freedom);
  return out;
}

bool holds(const std::vector<int>& indices, int index) { return std::find(indices.begin(), indices.end(), index) != indices.end(); }

/// Estimated in both, or in one where the other is a truth; a variance of zero states no uncertainty to test.
std::vector<int> jointly_estimated(const Calibration& a, const Calibration& b, const Eigen::MatrixXd& p) {
  std::vector<int> joint;
  for (int i = 0; i < coefficient_count; ++i) {
    const bool in_a = a.estimated.empty() || holds(a.estimated, i), in_b = b.estimated.empty() || holds(b.estimated, i);
    if (in_a && in_b && p(i, i) > 0) joint.push_back(i);
  }
  return joint;
}

}  // namespace

std::optional<double> CoefficientDifference::sigmas() const {
  if (!uncertainty || *uncertainty == 0) return std::nullopt;
  return difference / *uncertainty;
}

std::optional<double> CoefficientDifference::user_sigmas() const {
  if (!user_uncertainty || *user_uncertainty == 0) return std::nullopt;
  return user_difference / *user_uncertainty;
}

Comparison compare(const Calibration& first, const Calibration& second) {
  const Calibration a = in_accelerometer_frame(first), b = in_accelerometer_frame(second);
  const Eigen::VectorXd value_a = values(a.model), value_b = values(b.model), e = value_b - value_a;
  const Eigen::MatrixXd p = table_covariance(a) + table_covariance(b), relative = to_relative(a.model);
  const Eigen::VectorXd d = relative * e, u = p.diagonal().cwiseSqrt(),
                        user_u = (relative * p * relative.transpose()).diagonal().cwiseMax(0).cwiseSqrt();

  Comparison out;
  for (int i = 0; i < coefficient_count; ++i) {
    const bool estimated = holds(a.estimated, i) || holds(b.estimated, i);
    if (!estimated && e(i) == 0) continue;
    const Coefficient& c = row_of(i);
    double largest = 0;  // of the term: its axes share a unit
    for (int k = 0; k < coefficient_count; ++k)
      if (row_of(k).triad == c.triad && row_of(k).term == c.term) largest = std::max({largest, std::abs(d(k)), user_u(k)});
    const UserUnit unit = user_unit(c, largest);
    CoefficientDifference x{i, value_a(i), value_b(i), e(i), std::nullopt, d(i) / unit.size, std::nullopt, unit.name};
    if (estimated) {
      x.uncertainty = u(i);
      x.user_uncertainty = user_u(i) / unit.size;
    }
    out.coefficients.push_back(x);
  }
  const std::vector<int> joint = jointly_estimated(a, b, p);
  out.consistency = consistency_of(e(joint), p(joint, joint));
  return out;
}

}  // namespace imulab
