// Normal equations of many parameters in a band, and few that all equations may have: a motion along time, and constants.
#pragma once

#include "imulab/core/decomposition.hpp"
#include "imulab/eigen.hpp"

#include <optional>
#include <vector>

namespace imulab::extrinsics {

/// [A B; B^T C] with a symmetric band matrix A.
class BorderedBand {
 public:
  using ThreeRows = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>;
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  /// `width`: elements of a row left of the diagonal.
  BorderedBand(Eigen::Index band, Eigen::Index width, Eigen::Index border)
      : width_(width), band(Rows::Zero(band, width + 1)), side(Rows::Zero(band, border)), corner(Eigen::MatrixXd::Zero(border, border)) {}

  /// Adds weight J^T J of three rows whose columns are `first` and following of the band, and `columns` of the border.
  void add(Eigen::Index first, const ThreeRows& of_band, const std::vector<int>& columns, const ThreeRows& of_border, double weight);
  /// Decomposes it in place. `with_border` false: the border is held. Throws Error where it is not positive definite.
  void factor(bool with_border);

  struct Solution {
    Eigen::VectorXd band, border;
  };
  Solution solve(const Eigen::VectorXd& of_band, const Eigen::VectorXd& of_border) const;
  /// v^T N^-1 v
  double squared_norm(const Eigen::VectorXd& of_band, const Eigen::VectorXd& of_border) const;
  /// What is left of a right side for the border once the band is eliminated; `of_band` begins at row `first` and is zero elsewhere.
  Eigen::VectorXd reduced(Eigen::Index first, const Eigen::VectorXd& of_band, const Eigen::VectorXd& of_border) const;
  /// corner - side^T A^-1 side
  Eigen::MatrixXd reduced(Eigen::MatrixXd corner_of, Rows side_of) const;
  /// The information about the border, and its inverse.
  const Eigen::MatrixXd& information() const { return information_; }
  Eigen::MatrixXd border_covariance() const { return schur_->inverse(); }
  /// L^-T x: of a draw with unit variances one with the covariance of the band, the border held.
  Eigen::VectorXd backward(Eigen::VectorXd x) const;

 private:
  /// L^-1 b of rows `first` and following.
  Eigen::VectorXd forward(Eigen::VectorXd b, Eigen::Index first = 0) const;

  Eigen::Index width_;
  void forward_rows(Rows& rows) const;

  Eigen::MatrixXd information_;
  std::optional<Cholesky> schur_;

 public:
  Rows band;               ///< element (i, j) of A is at (i, j - i + width)
  Rows side;               ///< B; L^-1 B once factored
  Eigen::MatrixXd corner;  ///< C
};

}  // namespace imulab::extrinsics
