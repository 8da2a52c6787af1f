// An estimate with the Cholesky factor of its covariance, for Kalman filters: exactly known observations after wide priors destroy a covariance
// numerically, not its factor.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/QR>

namespace imulab {

struct SquareRootEstimate {
  Eigen::VectorXd x;
  Eigen::MatrixXd factor;  ///< lower triangular; the covariance is factor * factor^T

  /// Zero, known exactly.
  explicit SquareRootEstimate(Eigen::Index size) : x(Eigen::VectorXd::Zero(size)), factor(Eigen::MatrixXd::Zero(size, size)) {}

  /// The last N states become `transition` times all states, plus noise of this positive definite covariance. The others, constants, keep their rows;
  /// the last columns take up the noise.
  template <int N>
  void predict(const Eigen::Matrix<double, N, Eigen::Dynamic>& transition, const Eigen::Matrix<double, N, N>& noise) {
    using Square = Eigen::Matrix<double, N, N>;
    x.tail<N>() = (transition * x).eval();
    const Eigen::MatrixXd rows = transition * factor.triangularView<Eigen::Lower>();
    factor.bottomLeftCorner(N, x.size() - N) = rows.leftCols(x.size() - N);
    Eigen::Matrix<double, 2 * N, N> both;
    both << rows.rightCols<N>().transpose(), Square(noise.llt().matrixL()).transpose();
    const Eigen::HouseholderQR<Eigen::Matrix<double, 2 * N, N>> qr(both);
    factor.bottomRightCorner<N, N>() = Square(qr.matrixQR().template topRows<N>().template triangularView<Eigen::Upper>()).transpose();
  }

  /// Observes one state, with a standard deviation that may be zero: Carlson's (1973) update of the factor, from the last column to the first.
  void observe(Eigen::Index state, double value, double sigma);

  /// Adds variance to one state: a factor's update by one vector.
  void add_variance(Eigen::Index state, double variance);
};

}  // namespace imulab
