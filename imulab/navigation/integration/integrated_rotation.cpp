#include "imulab/navigation/integration/integrated_rotation.hpp"

#include "imulab/core/rotation.hpp"

#include <Eigen/Geometry>

namespace imulab {

Vector3d IntegratedRotation::change(const TriadModel& from, const Matrix3d& from_g, const TriadModel& to, const Matrix3d& to_g) const {
  Vector3d dphi = phi[0] * (to.offset - from.offset);
  for (Eigen::Index j = 0; j < 3; ++j) {
    dphi += phi[static_cast<std::size_t>(1 + j)] * (to.matrix.col(j) - from.matrix.col(j));
    dphi += phi[static_cast<std::size_t>(4 + j)] * (to_g.col(j) - from_g.col(j));
  }
  return dphi + phi[7] * (to.quadratic - from.quadratic) + phi[8] * (to.cubic - from.cubic);
}

IntegratedRotation integrate_rotation(const Recording& recording, Range range, const SensorModel& model, const Scaling& scaling,
                                      const Vector3d& gyro_sigma, const RateEffects& effects) {
  IntegratedRotation sum;
  sum.C.setIdentity();
  for (Matrix3d& phi : sum.phi) phi.setZero();
  const Eigen::Index columns = std::ssize(effects.columns);
  sum.by_effect.setZero(3, columns);
  sum.effects = effects.values.size() > 0 ? effects.values : Eigen::VectorXd(Eigen::VectorXd::Zero(columns));
  Eigen::Matrix3Xd by_effect(3, columns);
  sum.covariance.setZero();
  sum.reading.setZero();
  sum.duration_s = 0;

  const Matrix3d noise = model.gyro.matrix * gyro_sigma.cwiseAbs2().asDiagonal() * model.gyro.matrix.transpose();
  Vector3d previous = Vector3d::Zero();
  for (std::size_t i = range.begin; i < range.end; ++i) {
    const Vector3d va = scaling.accel(reading_at(recording.accel, i));
    const Vector3d vg = scaling.gyro(reading_at(recording.gyro, i));
    const Vector3d force = output(model.accel, va);
    Vector3d rate = output(model.gyro, vg) + model.g_sensitivity * force;
    if (columns > 0) {
      EffectState state = effects.state(i);
      state.force = force, state.rate = rate;
      for (Eigen::Index k = 0; k < columns; ++k) by_effect.col(k) = effects.columns[static_cast<std::size_t>(k)].at(state).rate;
      if (effects.values.size() > 0) rate -= by_effect * effects.values;
    }
    const double dt =
        recording.gyro_increment || i == 0 ? recording.interval_s : 1e-9 * static_cast<double>(recording.time_ns[i] - recording.time_ns[i - 1]);
    const Vector3d angle = rate * dt;
    const Matrix3d before = sum.C;
    sum.C = before * rotation_exp(angle + previous.cross(angle) / 12);  // coning, one interval plus the previous
    previous = angle;
    const Matrix3d middle = (0.5 * dt) * (before + sum.C);  // C at the middle of the interval, times dt
    sum.phi[0] += middle;
    for (std::size_t j = 0; j < 3; ++j) {
      sum.phi[1 + j] += middle * vg[static_cast<Eigen::Index>(j)];
      sum.phi[4 + j] += middle * force[static_cast<Eigen::Index>(j)];
    }
    const Vector3d square = vg.cwiseAbs2();
    sum.phi[7] += middle * square.asDiagonal();
    sum.phi[8] += middle * square.cwiseProduct(vg).asDiagonal();
    for (Eigen::Index k = 0; k < columns; ++k) sum.by_effect.col(k) += middle * by_effect.col(k);
    sum.covariance += middle * noise * middle.transpose();
    sum.reading += vg * dt;
    sum.duration_s += dt;
  }
  return sum;
}

}  // namespace imulab
