#include "imulab/estimate/hybrid/error_equations.hpp"

#include "imulab/earth/earth.hpp"

#include <cmath>

namespace imulab::hybrid {

using Eigen::Index;
using Eigen::MatrixXd;

BlockSums::BlockSums() {
  gyro.fill(Matrix3d::Zero());
  gyro_velocity.fill(Matrix3d::Zero());
  accel.fill(Matrix3d::Zero());
}

MatrixXd transition(const BlockSums& s, const States& states, const Place& place) {
  MatrixXd t = MatrixXd::Zero(6, states.size());
  t.block<3, 3>(0, states.attitude()) = Matrix3d::Identity() - s.duration * skew<double>(earth_rate_enu(place.latitude));
  t.block<3, 3>(3, states.attitude()) = s.force;
  t.block<3, 3>(3, states.velocity()).setIdentity();
  for (Index k = 0; k < states.constants(); ++k) {
    if (states.corrects(k) < 0) continue;
    const Coefficient& c = coefficient(states.corrects(k));
    const auto input = static_cast<std::size_t>(c.column);
    const auto gyro = [&](std::size_t basis) { t.col(k) << -s.gyro[basis].col(c.row), -s.gyro_velocity[basis].col(c.row); };
    const auto accel = [&](const auto& column) { t.col(k).tail<3>() = column; };
    switch (c.term) {
      case Term::offset:
        c.triad == Triad::gyro ? gyro(0) : accel(s.accel[0].col(c.row));
        break;
      case Term::matrix:
        c.triad == Triad::gyro ? gyro(1 + input) : accel(s.accel[1 + input].col(c.row));
        break;
      case Term::g_sensitivity:
        gyro(4 + input);
        break;
      case Term::lever_arm:
        accel(s.lever_arm.col(3 * c.row + c.column));
        break;
      default:
        accel(s.quadratic.col(c.row));
    }
  }
  t(5, states.first(Group::gravity)) = place.gravity * s.duration;
  if (states.has(Group::latitude)) {
    const Vector3d by_latitude(0, -earth_rate * std::sin(place.latitude), earth_rate * std::cos(place.latitude));
    t.col(states.first(Group::latitude)) << s.duration * by_latitude, 0.5 * s.duration * (s.force * by_latitude);
  }
  if (states.has(Group::delay)) t.col(states.first(Group::delay)).tail<3>() = s.delay;
  return t;
}

Eigen::Matrix<double, 6, 6> process_noise(const BlockSums& s, const Noise& noise, const Matrix3d& C) {
  const Matrix3d gyro = C * noise.gyro.cwiseAbs2().asDiagonal() * C.transpose(), accel = C * noise.accel.cwiseAbs2().asDiagonal() * C.transpose();
  const double T = s.duration;
  const Matrix3d force = s.force / T;  // [f_n x], constant within the block
  const Matrix3d cross = (T * T / 2) * force * gyro;
  Eigen::Matrix<double, 6, 6> q;
  q << T * gyro, cross.transpose(), cross, T * accel + (T * T * T / 3) * force * gyro * force.transpose();
  return q;
}

}  // namespace imulab::hybrid
