#include "imulab/estimate/kernel/information.hpp"

#include "imulab/core/decomposition.hpp"
#include "imulab/error.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

#include <algorithm>
#include <cmath>

namespace imulab::kernel {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

Parameters::Parameters(Index size)
    : role(static_cast<std::size_t>(size), Role::estimated), offset(VectorXd::Zero(size)), sigma(VectorXd::Constant(size, no_prior)) {}

std::vector<Index> Parameters::with(Role wanted) const {
  std::vector<Index> at;
  for (std::size_t i = 0; i < role.size(); ++i)
    if (role[i] == wanted) at.push_back(static_cast<Index>(i));
  return at;
}

Information::Information(Index parameters) : N(MatrixXd::Zero(parameters, parameters)), g(VectorXd::Zero(parameters)) {}

Information::Information(const MatrixXd& jacobian, const VectorXd& residual)
    : N(MatrixXd::Zero(jacobian.cols(), jacobian.cols())),
      g(jacobian.transpose() * residual),
      chi2(residual.squaredNorm()),
      rows(static_cast<int>(residual.size())) {
  if (rows > 0) N.selfadjointView<Eigen::Lower>().rankUpdate(jacobian.transpose());
  N.triangularView<Eigen::StrictlyUpper>() = N.transpose();
}

Information& Information::operator+=(const Information& other) {
  if (N.size() == 0) return *this = other;
  N += other.N, g += other.g, chi2 += other.chi2, rows += other.rows;
  return *this;
}

Information Information::operator-(const Information& other) const {
  Information out = *this;
  out.N -= other.N, out.g -= other.g, out.chi2 -= other.chi2, out.rows -= other.rows;
  return out;
}

namespace {

/// Returns the inverse of a positive definite matrix, or an empty matrix if it is not positive definite. Large sparse matrices (each of many
/// parameters is coupled to a few others) are factored as sparse matrices.
MatrixXd inverse_of(const MatrixXd& matrix) {
  constexpr Index large = 64;
  const Index n = matrix.rows();
  const MatrixXd identity = MatrixXd::Identity(n, n);
  if (n >= large && (matrix.array() != 0).count() < n * n / 3) {
    const Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> factor(matrix.sparseView());
    return factor.info() == Eigen::Success ? MatrixXd(factor.solve(identity)) : MatrixXd();
  }
  const Cholesky factor(matrix);
  return factor.positive_definite() ? factor.inverse() : MatrixXd();
}

/// Normal equations of the parameters that are not fixed, scaled to a unit diagonal.
struct NormalEquations {
  std::vector<Index> loose;
  VectorXd fixed;   ///< values of the other parameters
  VectorXd weight;  ///< weights of the priors; zero without a prior
  VectorXd right, scale;
  MatrixXd normal;
};

NormalEquations normal_equations(const Information& data, const Parameters& parameters) {
  NormalEquations e;
  e.fixed = VectorXd::Zero(parameters.size());
  for (Index i = 0; i < parameters.size(); ++i) {
    if (parameters.role[static_cast<std::size_t>(i)] == Role::fixed)
      e.fixed[i] = parameters.offset[i];
    else
      e.loose.push_back(i);
  }
  const auto n = static_cast<Index>(e.loose.size());
  e.weight.resize(n);
  VectorXd pull(n);
  for (Index k = 0; k < n; ++k) {
    const Index i = e.loose[static_cast<std::size_t>(k)];
    e.weight[k] = 1 / (parameters.sigma[i] * parameters.sigma[i]);
    pull[k] = e.weight[k] > 0 ? e.weight[k] * parameters.offset[i] : 0;
  }
  e.right = pull - VectorXd((data.g + data.N * e.fixed)(e.loose));
  e.normal = data.N(e.loose, e.loose);
  e.normal.diagonal() += e.weight;
  e.scale = e.normal.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  e.normal = e.scale.asDiagonal() * e.normal * e.scale.asDiagonal();
  return e;
}

/// Derivatives by the parameters that are not fixed, and one row per prior, as Q R, with columns of unit length.
struct RootEquations {
  std::vector<Index> loose;
  VectorXd fixed, weight;  ///< as in the normal equations
  VectorXd scale;          ///< scale of each column
  OrthogonalTriangular factors;

  MatrixXd by_triangle(const MatrixXd& right) const {  // scale R^-1 right
    return scale.asDiagonal() * Cholesky::of_lower(factors.R.transpose()).solve_upper(right);
  }
};

RootEquations root_equations(const MatrixXd& jacobian, const Parameters& parameters) {
  RootEquations e;
  e.fixed = VectorXd::Zero(parameters.size());
  for (Index i = 0; i < parameters.size(); ++i) {
    if (parameters.role[static_cast<std::size_t>(i)] == Role::fixed)
      e.fixed[i] = parameters.offset[i];
    else
      e.loose.push_back(i);
  }
  const VectorXd root_weight = VectorXd(parameters.sigma(e.loose)).cwiseInverse();
  MatrixXd rows(jacobian.rows() + root_weight.size(), root_weight.size());
  rows << jacobian(Eigen::all, e.loose), MatrixXd(root_weight.asDiagonal());
  e.weight = root_weight.cwiseAbs2();
  e.scale = rows.colwise().norm().transpose().cwiseMax(1e-300).cwiseInverse();
  e.factors = orthogonal_triangular(rows * e.scale.asDiagonal());
  return e;
}

constexpr double singular = 1e-13;  // with a unit diagonal, rounding alone makes pivots of 1e-14

[[noreturn]] void refuse(std::string_view what) {
  throw Unsupported(std::string(what) +
                    " do not determine the requested parameters; expected more of them, in other directions or at other values, or "
                    "fewer terms (the normal equations are singular)");
}

RootEquations regular_root_equations(const MatrixXd& jacobian, const Parameters& parameters, std::string_view what) {
  RootEquations e = root_equations(jacobian, parameters);
  constexpr double singular_root = 1e-12;  // with columns of unit length, rounding alone makes pivots of 1e-15
  if (!e.factors.R.allFinite() || !(e.loose.empty() || e.factors.R.diagonal().minCoeff() > singular_root)) refuse(what);
  return e;
}

}  // namespace

VectorXd correction(const Information& data, Parameters parameters, std::string_view what) {
  std::replace(parameters.role.begin(), parameters.role.end(), Role::considered, Role::fixed);
  const NormalEquations e = normal_equations(data, parameters);
  const Cholesky factor(e.normal);
  if (!factor.positive_definite() || !(e.loose.empty() || factor.lower().diagonal().cwiseAbs2().minCoeff() > singular)) refuse(what);
  VectorXd x = e.fixed;
  x(e.loose) = e.scale.cwiseProduct(factor.solve(e.scale.cwiseProduct(e.right)));
  return x;
}

Solution solve(const Information& data, const Parameters& parameters, std::string_view what) {
  const NormalEquations e = normal_equations(data, parameters);
  const auto n = static_cast<Index>(e.loose.size());
  const MatrixXd inverse = inverse_of(e.normal);
  if (inverse.rows() != n || !inverse.allFinite() || (n > 0 && inverse.diagonal().maxCoeff() > 1 / singular)) refuse(what);
  Solution s;
  s.x = e.fixed;
  const MatrixXd p = e.scale.asDiagonal() * inverse * e.scale.asDiagonal();
  s.x(e.loose) = p * e.right;
  s.covariance = MatrixXd::Zero(parameters.size(), parameters.size());
  s.covariance(e.loose, e.loose) = p;
  consider(s.x, s.covariance, parameters);
  s.chi2 = data.at(s.x);
  s.degrees_of_freedom = data.rows - static_cast<double>(n) + p.diagonal().dot(e.weight);
  return s;
}

double log_probability(const Information& data, Parameters parameters, std::string_view what) {
  std::replace(parameters.role.begin(), parameters.role.end(), Role::considered, Role::estimated);
  const Solution solution = solve(data, parameters, what);
  const NormalEquations e = normal_equations(data, parameters);
  double sum = solution.chi2 + 2 * (Cholesky(e.normal).lower().diagonal().array().log() - e.scale.array().log()).sum();
  for (const Index i : e.loose)
    if (std::isfinite(parameters.sigma[i]))
      sum += std::pow((solution.x[i] - parameters.offset[i]) / parameters.sigma[i], 2) + 2 * std::log(parameters.sigma[i]);
  return -0.5 * sum;
}

Solution solve(const MatrixXd& jacobian, const VectorXd& residual, const Parameters& parameters, std::string_view what) {
  const RootEquations e = regular_root_equations(jacobian, parameters, what);
  const auto n = static_cast<Index>(e.loose.size());
  VectorXd right(residual.size() + n);
  right.head(residual.size()) = -(residual + jacobian * e.fixed);
  right.tail(n) = e.weight.cwiseSqrt().cwiseProduct(VectorXd(parameters.offset(e.loose)));
  Solution s;
  s.x = e.fixed;
  s.x(e.loose) = VectorXd(e.by_triangle(e.factors.Q.transpose() * right));
  const MatrixXd root = e.by_triangle(MatrixXd::Identity(n, n));
  const MatrixXd p = root * root.transpose();
  s.covariance = MatrixXd::Zero(parameters.size(), parameters.size());
  s.covariance(e.loose, e.loose) = p;
  consider(s.x, s.covariance, parameters);
  s.chi2 = (residual + jacobian * s.x).squaredNorm();
  s.degrees_of_freedom = static_cast<double>(residual.size() - n) + p.diagonal().dot(e.weight);
  return s;
}

MatrixXd gain(const MatrixXd& jacobian, const Parameters& parameters, std::string_view what) {
  const RootEquations e = regular_root_equations(jacobian, parameters, what);
  MatrixXd out = MatrixXd::Zero(parameters.size(), jacobian.rows());
  out(e.loose, Eigen::all) = e.by_triangle(e.factors.Q.topRows(jacobian.rows()).transpose());
  return out;
}

void consider(VectorXd& x, MatrixXd& covariance, const Parameters& parameters) {
  const std::vector<Index> c = parameters.with(Role::considered);
  if (c.empty()) return;
  const MatrixXd columns = covariance(Eigen::all, c), own = columns(c, Eigen::all);
  const MatrixXd gain = solve_semidefinite(own, MatrixXd(columns.transpose())).transpose();
  const MatrixXd prior = parameters.sigma(c).cwiseAbs2().asDiagonal();
  x += gain * VectorXd(parameters.offset(c) - x(c));
  covariance += gain * (prior - own) * gain.transpose();
}

std::vector<Index> undetermined(const MatrixXd& covariance, const Parameters& parameters, const VectorXd& needed) {
  std::vector<Index> out;
  for (const Index i : parameters.with(Role::estimated))
    if (i < needed.size() && !(std::sqrt(covariance(i, i)) < needed[i])) out.push_back(i);
  return out;
}

double condition_number(const MatrixXd& symmetric) {
  if (symmetric.size() == 0) return 1;
  const VectorXd scale = symmetric.diagonal().cwiseSqrt().cwiseInverse();
  const VectorXd values = MatrixXd(scale.asDiagonal() * symmetric * scale.asDiagonal()).selfadjointView<Eigen::Lower>().eigenvalues();
  return std::sqrt(values.maxCoeff() / std::max(values.minCoeff(), 1e-300));
}

double condition_number(const Information& data, const Parameters& parameters) {
  const std::vector<Index> estimated = parameters.with(Role::estimated);
  MatrixXd normal = data.N(estimated, estimated);
  normal.diagonal() += VectorXd(parameters.sigma(estimated)).cwiseAbs2().cwiseInverse();
  return condition_number(normal);
}

double condition_number(const MatrixXd& jacobian, const Parameters& parameters) {
  Parameters estimated = parameters;
  std::replace(estimated.role.begin(), estimated.role.end(), Role::considered, Role::fixed);
  const VectorXd values = singular_values(root_equations(jacobian, estimated).factors.R).values;
  return values.size() == 0 ? 1 : values[0] / std::max(values[values.size() - 1], 1e-300);
}

}  // namespace imulab::kernel
