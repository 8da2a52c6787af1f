// Covariance matrices that couple neighboring blocks only.
#pragma once

#include <Eigen/Core>

#include <vector>

namespace imulab {

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
Eigen::MatrixXd whitened(const BlockTridiagonal& covariance, Eigen::MatrixXd x);

}  // namespace imulab
