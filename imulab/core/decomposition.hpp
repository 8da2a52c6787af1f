// Decompositions of dense matrices. Their templates are the slowest of all to compile, so they are instantiated in this source and nowhere else;
// hot loops on matrices of a few rows use Eigen's own, whose size is fixed.
#pragma once

#include "imulab/eigen.hpp"

#include <Eigen/Cholesky>
#include <Eigen/QR>

#include <optional>
#include <vector>

namespace imulab {

/// Type of the solution for a right side B: a vector for a vector, else a matrix.
template <class B>
using LikeRightSide = Eigen::Matrix<double, Eigen::Dynamic, B::ColsAtCompileTime == 1 ? 1 : Eigen::Dynamic>;

/// A = L L^T of a symmetric positive definite matrix. Only the lower half of A is read.
class Cholesky {
 public:
  explicit Cholesky(const Eigen::MatrixXd& a);
  /// The decomposition of A = L L^T with known L.
  static Cholesky of_lower(Eigen::MatrixXd lower);
  bool positive_definite() const { return positive_definite_; }  ///< false: the results mean nothing
  const Eigen::MatrixXd& lower() const { return lower_; }        ///< L, with zeros above the diagonal
  Eigen::MatrixXd inverse() const;                               ///< A^-1
  Eigen::MatrixXd inverse_lower() const;                         ///< L^-1

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

/// A part of a covariance, limited to all of it in every direction.
Eigen::MatrixXd limited_part(const Eigen::MatrixXd& part, const Eigen::MatrixXd& covariance);
/// A part of both: along each common axis of a and b, the smaller of the two. Equal ones have all in common.
Eigen::MatrixXd common_part(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

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

// Covariance matrices that couple neighboring blocks only.

/// Rows first .. first + size - 1 of the matrix; `covariance` of them, `coupling` with the rows of the block before (empty for none).
struct CovarianceBlock {
  Eigen::Index first = 0, size = 0;
  Eigen::MatrixXd covariance, coupling;
};
/// Blocks in the order of their rows, without gaps.
using BlockTridiagonal = std::vector<CovarianceBlock>;

/// The diagonal.
Eigen::VectorXd variances(const BlockTridiagonal& covariance);

/// These rows and columns.
Eigen::MatrixXd part_of(const BlockTridiagonal& covariance, const std::vector<Eigen::Index>& rows);

/// L^-1 x for the covariance L L^T: of errors, uncorrelated ones of unit variance.
Eigen::MatrixXd whitened(const BlockTridiagonal& covariance, Eigen::MatrixXd x, double* log_determinant = nullptr);  ///< of L L^T

// An estimate with the Cholesky factor of its covariance, for Kalman filters: exactly known observations after wide priors destroy a covariance
// numerically, not its factor.

struct SquareRootEstimate {
  Eigen::VectorXd x;
  Eigen::MatrixXd factor;  ///< lower triangular; the covariance is factor * factor^T

  /// Zero, known exactly.
  explicit SquareRootEstimate(Eigen::Index size) : x(Eigen::VectorXd::Zero(size)), factor(Eigen::MatrixXd::Zero(size, size)) {}

  /// The last N states become `transition` times all states, plus `noise` times M white ones of unit variance. The others, constants, keep their
  /// rows; the last columns take up the noise.
  template <int N, int M>
  void predict(const Eigen::Matrix<double, N, Eigen::Dynamic>& transition, const Eigen::Matrix<double, N, M>& noise) {
    using Square = Eigen::Matrix<double, N, N>;
    x.tail<N>() = (transition * x).eval();
    const Eigen::MatrixXd rows = transition * factor.triangularView<Eigen::Lower>();
    factor.bottomLeftCorner(N, x.size() - N) = rows.leftCols(x.size() - N);
    Eigen::Matrix<double, N + M, N> both;
    both << rows.rightCols<N>().transpose(), noise.transpose();
    const Eigen::HouseholderQR<Eigen::Matrix<double, N + M, N>> qr(both);
    factor.bottomRightCorner<N, N>() = Square(qr.matrixQR().template topRows<N>().template triangularView<Eigen::Upper>()).transpose();
  }

  /// Observes one state, with a standard deviation that may be zero: Carlson's (1973) update of the factor, from the last column to the first.
  void observe(Eigen::Index state, double value, double sigma);

  /// Adds variance to one state: a factor's update by one vector.
  void add_variance(Eigen::Index state, double variance);
};

}  // namespace imulab
