#include "imulab/navigation/in_place/navigator.hpp"

#include "imulab/earth/earth.hpp"
#include "imulab/model/lever_arm.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace imulab::in_place {

using Eigen::Index;

namespace {

/// An IMU that rests on both sides of a gap rested inside it, too.
double interval(const Recording& r, std::size_t i, const Block& block) {
  if (block.at_rest && i > 0 && r.follows_gap(i)) return r.time_s(i) - r.time_s(i - 1);
  return r.interval(i, r.gyro_increment);
}

}  // namespace

Navigator::Navigator(const Recording& recording, const SensorModel& model, double delay, double latitude, double gravity,
                     const OptionalSums& optional)
    : readings(recording, model),
      recording_(recording),
      lever_arm_(model.lever_arm),
      late_(std::clamp(delay / recording.interval_s, -1.0, 1.0)),
      optional_(optional),
      earth_rate_(earth_rate_enu(latitude)),
      gravity_(0, 0, -gravity) {}

void Navigator::align(const Range& range) {
  Vector3d force = Vector3d::Zero(), rate = Vector3d::Zero();
  for (std::size_t i = range.begin; i < range.end; ++i) force += readings.force(i), rate += readings.rate(i);
  if (!(rate.cross(force).norm() > 0)) rate = force.unitOrthogonal();
  C_nb = rotation_from_directions(Vector3d::UnitZ(), Vector3d::UnitY(), force, rate);
}

/// By differences of the neighbors: over a block these add up to the rate's change from its beginning to its end.
Vector3d Navigator::angular_acceleration(std::size_t i) {
  const std::size_t before = i > 0 ? i - 1 : 0, after = std::min(i + 1, recording_.size() - 1);
  return (readings.rate(after) - readings.rate(before)) / (static_cast<double>(after - before) * recording_.interval_s);
}

Vector3d Navigator::force_at_origin(std::size_t i) {
  const auto effect_at = [&](std::size_t k) { return Vector3d(size_effect(readings.rate(k), angular_acceleration(k), lever_arm_)); };
  const std::size_t neighbor = late_ > 0 ? std::max<std::size_t>(i, 1) - 1 : std::min(i + 1, recording_.size() - 1);
  return readings.force(i) - ((1 - std::abs(late_)) * effect_at(i) + std::abs(late_) * effect_at(neighbor));
}

BlockSums Navigator::over(const Block& block, std::size_t first) {
  BlockSums sum;
  if (block.observed || block.lost) velocity_.setZero();
  for (std::size_t i = block.samples.begin; i < block.samples.end; ++i) add(sum, i, first, block);
  return sum;
}

void Navigator::add(BlockSums& sum, std::size_t i, std::size_t first, const Block& block) {
  const double dt = interval(recording_, i, block);
  const Vector3d rate = readings.rate(i), force = block.at_rest || lever_arm_.isZero() ? readings.force(i) : force_at_origin(i);
  const Increment sample{rate * dt, force * dt};
  const integration::BodyStep step = i > first ? integration::body_step(sample, previous_) : integration::body_step({&sample, 1});
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
  // What an error multiplies, free of noise where it is known: an axis that measures nothing of rate or gravity would fit its own noise with a scale.
  const Vector3d w = block.at_rest ? Vector3d(half.transpose() * earth_rate_) : rate;
  const Vector3d f = block.observed ? Vector3d(half.transpose() * -gravity_) : force;
  const Matrix3d across = skew<double>(Vector3d(-gravity_));
  const std::array<double, 7> basis{1, w.x(), w.y(), w.z(), f.x(), f.y(), f.z()};
  const std::size_t used = optional_.g_sensitivity ? 7 : 4;
  for (std::size_t b = 0; b < used; ++b) {
    sum.gyro_velocity[b].noalias() += across * (dt * sum.gyro[b] + basis[b] * inner);
    sum.gyro[b] += basis[b] * middle;
  }
  if (!block.observed) {
    const Vector3d gained = pushed + dt * gravity_, moving = velocity_ + 0.5 * gained;
    const Matrix3d turned = skew<double>(moving) * middle;
    for (std::size_t b = 0; b < used; ++b) sum.gyro_velocity[b] -= basis[b] * turned;
    sum.path += dt * moving;
    velocity_ += gained;
  }
  sum.force += dt * across;
  sum.accel[0] += middle;
  for (Index b = 0; b < 3; ++b) {
    Matrix3d& accel = sum.accel[static_cast<std::size_t>(b) + 1];
    if (block.observed)  // C_nb f_b, f_b = C_bn (0, 0, g) itself turning
      accel += (-gravity_.z() * dt / 6) * (before(2, b) * before + 4 * half(2, b) * half + C_nb(2, b) * C_nb);
    else
      accel += force[b] * middle;
  }
  if (optional_.quadratic) sum.quadratic += middle * f.cwiseAbs2().asDiagonal();
  if (block.at_rest) return;
  if (optional_.delay) {  // of f' = -w x f and f'' = w x (w x f) - w' x f
    sum.delay += middle * rate.cross(force);
    sum.smear += 0.5 * middle * (rate.cross(rate.cross(force)) - angular_acceleration(i).cross(force));
  }
  if (!optional_.lever_arm) return;
  const Matrix3d effect = size_effect(rate, angular_acceleration(i));
  for (Index a = 0; a < 3; ++a) sum.lever_arm.middleCols<3>(3 * a) += middle.col(a) * effect.row(a);
}

}  // namespace imulab::in_place
