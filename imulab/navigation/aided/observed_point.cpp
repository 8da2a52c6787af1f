#include "imulab/navigation/aided/observed_point.hpp"

#include "imulab/core/rotation.hpp"

#include <utility>

namespace imulab::aided {

using Eigen::MatrixXd;
using Eigen::VectorXd;

ObservedRows rows_of(Eigen::Index count, Eigen::Index size) {
  return {VectorXd::Zero(count), MatrixXd::Zero(count, size), VectorXd::Zero(count), std::vector<std::size_t>(static_cast<std::size_t>(count))};
}

double offset_in_time(const Problem& p, const Channel& c, const Observation& o, const Instant& at) {
  return o.stamp - delay_at(p, c, at.state.x, o.stamp) - at.time;
}

void set_delay(const Problem& p, const Channel& c, const Observation& o, const VectorXd& rate, MatrixXd& derivative) {
  if (c.delay < 0) return;
  derivative.col(c.delay) = -rate;
  derivative.col(c.delay + 1) = -(o.stamp - p.delay_time()) * rate;
}

Vector3d lever_of(const Channel& c, const Instant& at) { return c.lever >= 0 ? Vector3d(at.state.x.segment<3>(c.lever)) : Vector3d::Zero(); }

MatrixXd rate_derivative(const Problem& p, const Instant& at) {
  MatrixXd out = MatrixXd::Zero(3, p.size);
  const Matrix3d C_bn = at.state.motion.q_nb.toRotationMatrix().transpose();
  out.middleCols<3>(At::attitude) = -C_bn * skew<double>(earth_rate_at(p, at.state));
  if (p.earth_rate >= 0) out.middleCols<3>(p.earth_rate) = -C_bn;
  for (const Eigen::Index first : {p.gyro_offset, p.gyro_flicker})
    if (first >= 0) out.middleCols<3>(first).setIdentity();
  for (Eigen::Index j = 0; j < 3; ++j) {
    if (p.gyro_matrix >= 0) out.middleCols<3>(p.gyro_matrix + 3 * j) = at.raw_rate[j] * Matrix3d::Identity();
    if (p.g_sensitivity >= 0) out.middleCols<3>(p.g_sensitivity + 3 * j) = at.raw_force[j] * Matrix3d::Identity();
  }
  if (p.gyro_delay >= 0) out.col(p.gyro_delay) = at.turning;
  if (p.terms) {
    Eigen::Matrix<double, 6, Eigen::Dynamic> changes(6, p.terms->sigma.size());
    p.terms->at(p.time[at.sample], p.samples[at.sample], changes);
    out.middleCols(p.terms_first, changes.cols()) = changes.topRows<3>();
  }
  return out;
}

Derived swing_of(const Problem& p, const Channel& c, const Instant& at) {
  const Vector3d lever = lever_of(c, at);
  Derived out{at.rate_eb.cross(lever), -skew<double>(lever) * rate_derivative(p, at)};
  if (c.lever >= 0) out.derivative.middleCols<3>(c.lever) = skew<double>(at.rate_eb);
  return out;
}

Derived velocity_of(const Problem& p, const Channel& c, const Instant& at) {
  const Matrix3d C = at.state.motion.q_nb.toRotationMatrix();
  const Derived swing = swing_of(p, c, at);
  const Vector3d swung = C * swing.value;
  Derived out{at.state.motion.velocity + swung, C * swing.derivative};
  out.derivative.middleCols<3>(At::attitude) -= skew<double>(swung);
  out.derivative.middleCols<3>(At::velocity).setIdentity();
  return out;
}

Vector3d acceleration_of(const Channel& c, const Instant& at) {
  const Vector3d lever = lever_of(c, at);
  return at.acceleration + at.state.motion.q_nb * (at.rate_eb.cross(at.rate_eb.cross(lever)) + at.turning.cross(lever));
}

ObservedRows joined_rows(ObservedRows a, const ObservedRows& b) {
  ObservedRows out = rows_of(a.residual.size() + b.residual.size(), a.derivative.cols());
  out.residual << a.residual, b.residual;
  out.derivative << a.derivative, b.derivative;
  out.variance << a.variance, b.variance;
  out.source = std::move(a.source);
  out.source.insert(out.source.end(), b.source.begin(), b.source.end());
  return out;
}

}  // namespace imulab::aided
