#include "imulab/core/decomposition.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>

#include <utility>

namespace imulab {

using Eigen::Lower;
using Eigen::MatrixXd;
using Eigen::VectorXd;

Cholesky::Cholesky(const MatrixXd& a) {
  const Eigen::LLT<MatrixXd> factor(a);
  lower_ = factor.matrixL();
  positive_definite_ = factor.info() == Eigen::Success;
}

Cholesky Cholesky::of_lower(MatrixXd lower) {
  Cholesky out;
  out.positive_definite_ = (lower.diagonal().array() > 0).all();
  out.lower_ = std::move(lower);
  return out;
}

MatrixXd Cholesky::inverse() const { return solve(MatrixXd::Identity(lower_.rows(), lower_.cols())); }

void Cholesky::forward(VectorXd& x) const { lower_.triangularView<Lower>().solveInPlace(x); }

void Cholesky::forward(MatrixXd& x) const { lower_.triangularView<Lower>().solveInPlace(x); }

void Cholesky::backward(VectorXd& x) const { lower_.triangularView<Lower>().transpose().solveInPlace(x); }

void Cholesky::backward(MatrixXd& x) const { lower_.triangularView<Lower>().transpose().solveInPlace(x); }

MatrixXd inverse_of(const MatrixXd& a) { return a.inverse(); }

std::optional<Eigen::Matrix3d> regular_inverse(const Eigen::Matrix3d& a) {
  const Eigen::FullPivLU<Eigen::Matrix3d> lu(a);
  return lu.isInvertible() ? std::optional(Eigen::Matrix3d(lu.inverse())) : std::nullopt;
}

MatrixXd solve_semidefinite(const MatrixXd& a, const MatrixXd& b) { return a.ldlt().solve(b); }

VectorXd solve_semidefinite(const MatrixXd& a, const VectorXd& b) { return a.ldlt().solve(b); }

double squared_norm_in(const MatrixXd& a, const VectorXd& b) { return b.dot(solve_semidefinite(a, b)); }

SymmetricEigen symmetric_eigen(const MatrixXd& a) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(a);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

VectorXd symmetric_eigenvalues(const MatrixXd& a) { return Eigen::SelfAdjointEigenSolver<MatrixXd>(a, Eigen::EigenvaluesOnly).eigenvalues(); }

SingularValues singular_values(const MatrixXd& a) {
  const Eigen::JacobiSVD<MatrixXd> svd(a, Eigen::ComputeThinU | Eigen::ComputeThinV);
  return {svd.matrixU(), svd.singularValues(), svd.matrixV()};
}

OrthogonalTriangular orthogonal_triangular(const MatrixXd& a) {
  const Eigen::HouseholderQR<MatrixXd> qr(a);
  OrthogonalTriangular out{qr.householderQ() * MatrixXd::Identity(a.rows(), a.cols()),
                           qr.matrixQR().topRows(a.cols()).triangularView<Eigen::Upper>()};
  for (Eigen::Index i = 0; i < a.cols(); ++i)
    if (out.R(i, i) < 0) out.R.row(i) *= -1, out.Q.col(i) *= -1;
  return out;
}

LeastSquares least_squares(const MatrixXd& a, const MatrixXd& b, std::optional<double> threshold) {
  Eigen::ColPivHouseholderQR<MatrixXd> qr(a);
  if (threshold) qr.setThreshold(*threshold);
  return {qr.solve(b), qr.rank()};
}

std::optional<VectorXd> solve_full_rank(const MatrixXd& a, const VectorXd& b, double threshold) {
  if (a.rows() < a.cols()) return {};
  const VectorXd norm = a.colwise().norm();
  if (!(norm.minCoeff() > 1e-6 * norm.maxCoeff())) return {};
  const Eigen::JacobiSVD<MatrixXd> svd(a * norm.cwiseInverse().asDiagonal(), Eigen::ComputeThinU | Eigen::ComputeThinV);
  if (svd.singularValues().minCoeff() < threshold * svd.singularValues().maxCoeff()) return {};
  return norm.cwiseInverse().cwiseProduct(svd.solve(b));
}

std::optional<MatrixXd> reverse_cholesky(const MatrixXd& a) {
  const Cholesky factor(a.reverse());  // rows and columns
  if (!factor.positive_definite()) return {};
  return MatrixXd(factor.lower().transpose().reverse());
}

}  // namespace imulab
