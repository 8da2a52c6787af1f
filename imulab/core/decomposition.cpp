#include "imulab/core/decomposition.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>

namespace imulab {

using Eigen::Lower;
using Eigen::MatrixXd;
using Eigen::VectorXd;

Cholesky::Cholesky(const MatrixXd& a) {
  const Eigen::LLT<MatrixXd> factor(a);
  lower_ = factor.matrixL();
  positive_definite_ = factor.info() == Eigen::Success;
}

MatrixXd Cholesky::inverse() const { return solve(MatrixXd::Identity(lower_.rows(), lower_.cols())); }

void Cholesky::forward(VectorXd& x) const { lower_.triangularView<Lower>().solveInPlace(x); }

void Cholesky::forward(MatrixXd& x) const { lower_.triangularView<Lower>().solveInPlace(x); }

void Cholesky::backward(VectorXd& x) const { lower_.triangularView<Lower>().transpose().solveInPlace(x); }

void Cholesky::backward(MatrixXd& x) const { lower_.triangularView<Lower>().transpose().solveInPlace(x); }

MatrixXd inverse_of(const MatrixXd& a) { return a.inverse(); }

MatrixXd solve_semidefinite(const MatrixXd& a, const MatrixXd& b) { return a.ldlt().solve(b); }

double squared_norm_in(const MatrixXd& a, const VectorXd& b) { return b.dot(a.ldlt().solve(b)); }

SymmetricEigen symmetric_eigen(const MatrixXd& a) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(a);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

VectorXd symmetric_eigenvalues(const MatrixXd& a) { return Eigen::SelfAdjointEigenSolver<MatrixXd>(a, Eigen::EigenvaluesOnly).eigenvalues(); }

SingularValues singular_values(const MatrixXd& a) {
  const Eigen::JacobiSVD<MatrixXd> svd(a, Eigen::ComputeThinU | Eigen::ComputeThinV);
  return {svd.matrixU(), svd.singularValues(), svd.matrixV()};
}

LeastSquares least_squares(const MatrixXd& a, const MatrixXd& b, std::optional<double> threshold) {
  Eigen::ColPivHouseholderQR<MatrixXd> qr(a);
  if (threshold) qr.setThreshold(*threshold);
  return {qr.solve(b), qr.rank()};
}

}  // namespace imulab
