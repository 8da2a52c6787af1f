#include "imulab/estimate/hybrid_navigator.hpp"

#include "imulab/core/rotation.hpp"
#include "imulab/earth/earth.hpp"
#include "imulab/model/compensate.hpp"

#include <Eigen/Geometry>

#include <algorithm>

namespace imulab {

using Eigen::Index;

namespace {

/// a_i = row i of this, times accelerometer i's place: w' x r + w x (w x r).
Matrix3d size_effect(const Vector3d& rate, const Vector3d& angular_acceleration) {
  return skew<double>(angular_acceleration) + rate * rate.transpose() - rate.squaredNorm() * Matrix3d::Identity();
}

}  // namespace

/// At rest there is no size effect; what the gyros' noise would make of one is correlated with what it does to the attitude.
HybridSamples compensated(const Recording& recording, const std::vector<HybridBlock>& blocks, const SensorModel& model) {
  HybridSamples s{recording.gyro, recording.accel};
  RawColumns raw;
  MotionColumns out;
  for (std::size_t j = 0; j < 3; ++j) {
    raw.gyro[j] = recording.gyro[j];
    raw.accel[j] = recording.accel[j];
    raw.gyro_temperature[j] = recording.gyro_temperature[j];
    raw.accel_temperature[j] = recording.accel_temperature[j];
    out.rate[j] = s.rate[j];
    out.force[j] = s.force[j];
  }
  compensate(model, raw, out);
  if (model.lever_arm.isZero()) return s;
  for (const HybridBlock& block : blocks)
    for (std::size_t i = block.samples.begin; i < block.samples.end && !block.at_rest; ++i) {
      const Matrix3d effect = size_effect(s.rate_at(i), s.angular_acceleration(i, recording.interval_s));
      for (std::size_t j = 0; j < 3; ++j) {
        const auto row = static_cast<Index>(j);
        s.force[j][i] -= effect.row(row).dot(model.lever_arm.row(row));
      }
    }
  return s;
}

HybridNavigator::HybridNavigator(const HybridSamples& samples, const Recording& recording, const HybridSite& site, const HybridLayout& layout)
    : samples_(samples), recording_(recording), layout_(layout), earth_rate_(earth_rate_enu(site.latitude)), gravity_(0, 0, -site.gravity) {}

void HybridNavigator::align(const Range& range) {
  Vector3d force = Vector3d::Zero(), rate = Vector3d::Zero();
  for (std::size_t i = range.begin; i < range.end; ++i) force += samples_.force_at(i), rate += samples_.rate_at(i);
  const Vector3d up = force.normalized();
  Vector3d east = rate.cross(up);
  if (!(east.norm() > 0)) east = up.unitOrthogonal();
  east.normalize();
  C_nb.row(0) = east.transpose();
  C_nb.row(1) = up.cross(east).transpose();
  C_nb.row(2) = up.transpose();
}

HybridSums HybridNavigator::over(const HybridBlock& block, std::size_t first) {
  HybridSums sum;
  for (Matrix3d& m : sum.gyro) m.setZero();
  for (Matrix3d& m : sum.gyro_velocity) m.setZero();
  for (Matrix3d& m : sum.accel) m.setZero();
  for (std::size_t i = block.samples.begin; i < block.samples.end; ++i) add(sum, i, first, block);
  return sum;
}

/// A unit that rests on both sides of a gap rested inside it, too.
double HybridNavigator::interval(std::size_t i, const HybridBlock& block) const {
  if (block.at_rest && i > 0 && std::binary_search(recording_.gaps.begin(), recording_.gaps.end(), i))
    return recording_.time_s(i) - recording_.time_s(i - 1);
  return recording_.interval(i, recording_.gyro_increment);
}

void HybridNavigator::add(HybridSums& sum, std::size_t i, std::size_t first, const HybridBlock& block) {
  const double dt = interval(i, block);
  const Vector3d rate = samples_.rate_at(i), force = samples_.force_at(i);
  const Increment sample{rate * dt, force * dt};
  const BodyStep step = i > first ? body_step(sample, previous_) : body_step({&sample, 1});
  previous_ = sample;

  const Vector3d turn = dt * earth_rate_;  // of east-north-up
  const Vector3d turn_b = C_nb.transpose() * turn;
  const Vector3d pushed = C_nb * step.velocity;
  const Matrix3d before = C_nb;
  C_nb = before * rotation_exp(step.rotation - turn_b - 0.5 * turn_b.cross(step.rotation));  // exp(-turn) C exp(rotation)
  sum.velocity += pushed - 0.5 * turn.cross(pushed) + dt * gravity_;
  sum.duration += dt;

  // Within the sample, by Simpson's rule: unobservable directions stay so only as far as the derivatives are true.
  const Matrix3d K = skew<double>(step.rotation);
  const Matrix3d half = 0.5 * (before + C_nb) - 0.125 * before * K * K;
  const Matrix3d middle = (dt / 6) * (before + 4 * half + C_nb), inner = (dt * dt / 6) * (before + 2 * half);
  const Matrix3d across = skew<double>(pushed) / dt;  // [f_n x]
  // What an error multiplies, free of noise where it is known: an axis that sees nothing of rate or gravity would else explain its noise by its
  // scale.
  const Vector3d w = block.at_rest ? Vector3d(half.transpose() * earth_rate_) : rate;
  const Vector3d f = block.observed ? Vector3d(half.transpose() * -gravity_) : force;
  const std::array<double, 7> basis{1, w.x(), w.y(), w.z(), f.x(), f.y(), f.z()};
  const std::size_t used = layout_.g_sensitivity >= 0 ? 7 : 4;
  for (std::size_t b = 0; b < used; ++b) {
    sum.gyro_velocity[b].noalias() += across * (dt * sum.gyro[b] + basis[b] * inner);
    sum.gyro[b] += basis[b] * middle;
  }
  sum.force += dt * across;
  sum.accel[0] += middle;
  for (Index b = 0; b < 3; ++b) {
    if (block.observed)  // C_nb f_b, f_b = C_bn (0, 0, g) itself turning
      sum.accel[static_cast<std::size_t>(b) + 1] += (-gravity_.z() * dt / 6) * (before(2, b) * before + 4 * half(2, b) * half + C_nb(2, b) * C_nb);
    else
      sum.accel[static_cast<std::size_t>(b) + 1] += force[b] * middle;
  }
  if (layout_.quadratic >= 0) sum.quadratic += middle * f.cwiseAbs2().asDiagonal();
  if (layout_.delay >= 0 && !block.at_rest) sum.delay += middle * rate.cross(force);
  if (layout_.lever_arm >= 0 && !block.at_rest) {
    const Matrix3d effect = size_effect(rate, samples_.angular_acceleration(i, recording_.interval_s));
    for (Index a = 0; a < 3; ++a) sum.lever_arm.middleCols<3>(3 * a) += middle.col(a) * effect.row(a);
  }
}

}  // namespace imulab
