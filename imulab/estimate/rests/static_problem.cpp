// The conditions of rests without rotations.
#include "imulab/core/rotation.hpp"
#include "imulab/earth.hpp"
#include "imulab/estimate/rests/problem.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace imulab::rests {

using Eigen::Index;
using Eigen::MatrixXd;

StaticProblem::StaticProblem(const coarse::RestStart& start, const Site& site, std::vector<CoefficientIndex> indices, bool with_gyros)
    : RestProblem(start, site, std::move(indices)), with_gyros_(with_gyros) {}

Conditions StaticProblem::conditions(const Spreads& spreads) const {
  const Index per_rest = with_gyros_ ? 3 : 1, rests = static_cast<Index>(rests_.size());
  Conditions c(per_rest * rests, std::ssize(indices_) + effects_.size());
  for (Index k = 0; k < rests; ++k) add_rest(c, per_rest * k, rests_[static_cast<std::size_t>(k)], spreads);
  return c;
}

void StaticProblem::add_rest(Conditions& c, Index row, const Rest& rest, const Spreads& spreads) const {
  const Index rows = with_gyros_ ? 3 : 1;
  const Vector3d force = force_at(rest), up = force.normalized();
  // These are the derivatives of the rest's rows by its force and by its rate.
  MatrixXd rows_by_force = MatrixXd::Zero(rows, 3), rows_by_rate = MatrixXd::Zero(rows, 3);
  rows_by_force.row(0) = up.transpose();
  c.value[row] = force.norm() - gravity_;
  Matrix3d rate_noise = Matrix3d::Zero();
  if (with_gyros_) {
    const Vector3d rate = rate_at(rest);
    const double vertical = up.dot(rate);
    const Vector3d across = rate - vertical * up, north = across.normalized(), east = north.cross(up);
    const Matrix3d turn_up = direction_derivative(force);
    rate_noise = rate_covariance(rest, spreads[1]);
    rows_by_rate.row(1) = up.transpose();
    rows_by_force.row(1) = rate.transpose() * turn_up;
    rows_by_rate.row(2) = north.transpose();
    rows_by_force.row(2) = -vertical * north.transpose() * turn_up;
    c.value[row + 1] = vertical - earth_rate * std::sin(*latitude_);
    // Noise across north increases the horizontal part by var / (2 |w|) on average.
    c.value[row + 2] = across.norm() - east.dot(rate_noise * east) / (2 * across.norm()) - earth_rate * std::cos(*latitude_);
    std::fill_n(c.kind.begin() + row + 1, 2, Kind::gyro_rest);
  }
  add_derivatives(c, row, Triad::accel, rest, rows_by_force);
  add_derivatives(c, row, Triad::gyro, rest, rows_by_rate);
  c.blocks.push_back(
      {row,
       rows,
       rows_by_force * force_covariance(rest, spreads[0]) * rows_by_force.transpose() + rows_by_rate * rate_noise * rows_by_rate.transpose(),
       {}});
}

}  // namespace imulab::rests
