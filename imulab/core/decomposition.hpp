// Decompositions of dense matrices. Their templates are the slowest of all to compile, so they are instantiated in this source and nowhere else;
// hot loops on matrices of a few rows use Eigen's own, whose size is fixed.
#pragma once

#include <Eigen/Core>

#include <optional>

namespace imulab {

/// What a system with the right side B solves to: a vector for a vector, else a matrix.
template <class B>
using LikeRightSide = Eigen::Matrix<double, Eigen::Dynamic, B::ColsAtCompileTime == 1 ? 1 : Eigen::Dynamic>;

/// A = L L^T of a symmetric positive definite matrix. Only the lower half of A is read.
class Cholesky {
 public:
  explicit Cholesky(const Eigen::MatrixXd& a);
  /// Of A = L L^T whose L is known.
  static Cholesky of_lower(Eigen::MatrixXd lower);
  bool positive_definite() const { return positive_definite_; }  ///< false: the results mean nothing
  const Eigen::MatrixXd& lower() const { return lower_; }        ///< L, with zeros above the diagonal
  Eigen::MatrixXd inverse() const;                               ///< A^-1

  template <class B>
  LikeRightSide<B> solve(const B& b) const {  ///< A^-1 b
    return solve_upper(solve_lower(b));
  }
  template <class B>
  LikeRightSide<B> solve_lower(const B& b) const {  ///< L^-1 b: of residuals with covariance A, residuals with unit variance
    LikeRightSide<B> x = b;
    forward(x);
    return x;
  }
  template <class B>
  LikeRightSide<B> solve_upper(const B& b) const {  ///< L^-T b
    LikeRightSide<B> x = b;
    backward(x);
    return x;
  }

 private:
  Cholesky() = default;
  void forward(Eigen::VectorXd& x) const;
  void forward(Eigen::MatrixXd& x) const;
  void backward(Eigen::VectorXd& x) const;
  void backward(Eigen::MatrixXd& x) const;

  Eigen::MatrixXd lower_;
  bool positive_definite_ = true;
};

/// A^-1 of any regular square matrix (LU with partial pivoting).
Eigen::MatrixXd inverse_of(const Eigen::MatrixXd& a);
/// Empty where A is singular up to rounding (LU with full pivoting).
std::optional<Eigen::Matrix3d> regular_inverse(const Eigen::Matrix3d& a);

/// A^-1 b of a symmetric positive semidefinite matrix (L D L^T with pivoting); zero in its null space. Only the lower half of A is read.
Eigen::MatrixXd solve_semidefinite(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);
Eigen::VectorXd solve_semidefinite(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);
/// b^T A^-1 b by the same: chi-square of errors b with covariance A.
double squared_norm_in(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);

/// A = V diag(values) V^T of a symmetric matrix, values ascending. Only the lower half of A is read.
struct SymmetricEigen {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;  ///< columns
};
SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& a);
Eigen::VectorXd symmetric_eigenvalues(const Eigen::MatrixXd& a);

/// A = U diag(values) V^T, thin, values descending.
struct SingularValues {
  Eigen::MatrixXd U;
  Eigen::VectorXd values;
  Eigen::MatrixXd V;
};
SingularValues singular_values(const Eigen::MatrixXd& a);

/// A = Q R, thin, R upper triangular with a positive diagonal: R^T is the Cholesky factor of A^T A without the squares, which have twice the digits.
struct OrthogonalTriangular {
  Eigen::MatrixXd Q, R;
};
/// For at least as many rows as columns.
OrthogonalTriangular orthogonal_triangular(const Eigen::MatrixXd& a);

/// Least squares min |A x - b|, a column of x for each of b, by QR with column pivoting.
struct LeastSquares {
  Eigen::MatrixXd x;
  Eigen::Index rank;  ///< pivots above `threshold` times the largest; below the number of unknowns, x is one of many solutions
};
/// Without a threshold: rounding decides.
LeastSquares least_squares(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b, std::optional<double> threshold = {});

/// Least squares with a rank test: empty where the least singular value of A with columns of unit length is below `threshold` times the largest, or a
/// column vanishes beside another.
std::optional<Eigen::VectorXd> solve_full_rank(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, double threshold);

/// L lower triangular with A = L^T L: the Cholesky factor taken from the last row upwards. Empty where A is not positive definite.
std::optional<Eigen::MatrixXd> reverse_cholesky(const Eigen::MatrixXd& a);

}  // namespace imulab
