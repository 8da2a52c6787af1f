#include "imulab/estimate/extrinsics/bordered_band.hpp"

#include "imulab/error.hpp"

#include <algorithm>
#include <cmath>

namespace imulab::extrinsics {

void BorderedBand::add(Eigen::Index first, const ThreeRows& of_band, const std::vector<int>& columns, const ThreeRows& of_border, double weight) {
  const auto combined = [weight](const ThreeRows& rows, Eigen::Index n, const Vector3d& v) {
    return weight * (v[0] * rows.row(0).head(n) + v[1] * rows.row(1).head(n) + v[2] * rows.row(2).head(n));
  };
  const Eigen::Index m = of_border.cols();
  Eigen::RowVectorXd scattered(m);
  for (Eigen::Index i = 0; i < of_band.cols(); ++i) {
    const Vector3d column = of_band.col(i);
    if (column.isZero(0)) continue;
    band.row(first + i).segment(width_ - i, i + 1) += combined(of_band, i + 1, column);
    scattered = combined(of_border, m, column);
    for (Eigen::Index j = 0; j < m; ++j) side(first + i, columns[static_cast<std::size_t>(j)]) += scattered[j];
  }
  for (Eigen::Index i = 0; i < m; ++i) {
    scattered = combined(of_border, m, of_border.col(i));
    for (Eigen::Index j = 0; j < m; ++j) corner(columns[static_cast<std::size_t>(j)], columns[static_cast<std::size_t>(i)]) += scattered[j];
  }
}

void BorderedBand::factor(bool with_border) {
  for (Eigen::Index i = 0; i < band.rows(); ++i) {
    const Eigen::Index begin = std::max<Eigen::Index>(0, i - width_);
    for (Eigen::Index j = begin; j < i; ++j) {
      const Eigen::Index common = std::max(begin, j - width_), n = j - common;
      double& x = band(i, j - i + width_);
      x = (x - band.row(i).segment(common - i + width_, n).dot(band.row(j).segment(common - j + width_, n))) / band(j, width_);
    }
    const double left = band(i, width_) - band.row(i).segment(begin - i + width_, i - begin).squaredNorm();
    if (!(left > 0)) throw Error("the motion's equations are singular; expected readings without long gaps");
    band(i, width_) = std::sqrt(left);
  }
  if (with_border)
    forward_rows(side);
  else
    side.setZero();
  information_ = corner;
  information_.selfadjointView<Eigen::Lower>().rankUpdate(side.transpose(), -1);
  information_.triangularView<Eigen::StrictlyUpper>() = information_.transpose();
  constexpr double regularity = 1e-12;  // what rounding leaves of a border that the band takes up
  information_.diagonal() += regularity * corner.diagonal();
  schur_.emplace(information_);
  if (!schur_->positive_definite()) throw Error("the mountings' equations are singular; expected finite readings of ordinary size");
}

Eigen::VectorXd BorderedBand::forward(Eigen::VectorXd b, Eigen::Index first) const {
  for (Eigen::Index i = 0; i < b.size(); ++i) {
    const Eigen::Index n = std::min(i, width_);
    b[i] = (b[i] - band.row(first + i).segment(width_ - n, n).dot(b.segment(i - n, n))) / band(first + i, width_);
  }
  return b;
}

Eigen::VectorXd BorderedBand::reduced(Eigen::Index first, const Eigen::VectorXd& of_band, const Eigen::VectorXd& of_border) const {
  constexpr Eigen::Index reach = 20;  // widths of the band, after which what is left of a right side is negligible
  Eigen::VectorXd b = Eigen::VectorXd::Zero(std::min(of_band.size() + reach * width_, band.rows() - first));
  b.head(of_band.size()) = of_band;
  return of_border - side.middleRows(first, b.size()).transpose() * forward(b, first);
}

void BorderedBand::forward_rows(Rows& rows) const {
  for (Eigen::Index i = 0; i < band.rows(); ++i) {
    const Eigen::Index n = std::min(i, width_);
    rows.row(i) -= band.row(i).segment(width_ - n, n) * rows.middleRows(i - n, n);
    rows.row(i) /= band(i, width_);
  }
}

Eigen::MatrixXd BorderedBand::reduced(Eigen::MatrixXd corner_of, Rows side_of) const {
  forward_rows(side_of);
  corner_of.noalias() -= side_of.transpose() * side_of;
  return corner_of;
}

Eigen::VectorXd BorderedBand::backward(Eigen::VectorXd x) const {
  for (Eigen::Index i = band.rows() - 1; i >= 0; --i) {
    const Eigen::Index n = std::min(i, width_);
    x[i] /= band(i, width_);
    x.segment(i - n, n) -= x[i] * band.row(i).segment(width_ - n, n).transpose();
  }
  return x;
}

BorderedBand::Solution BorderedBand::solve(const Eigen::VectorXd& of_band, const Eigen::VectorXd& of_border) const {
  Solution x;
  x.band = forward(of_band);
  x.border = schur_->solve(Eigen::VectorXd(of_border - side.transpose() * x.band));
  x.band = backward(x.band - side * x.border);
  return x;
}

double BorderedBand::squared_norm(const Eigen::VectorXd& of_band, const Eigen::VectorXd& of_border) const {
  const Eigen::VectorXd y = forward(of_band);
  return y.squaredNorm() + schur_->solve_lower(Eigen::VectorXd(of_border - side.transpose() * y)).squaredNorm();
}

}  // namespace imulab::extrinsics
