#include "imulab/navigation/in_place/error_sums.hpp"

#include "imulab/earth.hpp"
#include "imulab/model/compensation_derivatives.hpp"

#include <cmath>
#include <numbers>

namespace imulab::in_place {

Noise noise_of(const Vector3d& gyro, const Vector3d& accel, const NoiseModels& declared, double duration_s) {
  // Processes with a variance of B^2 / pi per unit of ln(time) have the two-sided power B^2 / (2 pi f) of flicker (IEEE 952, C.1.2). With a ratio of
  // 16, the Allan variance of their sum agrees with flicker within 10 % from the fastest time to half of the slowest. Slower ones count as constant.
  constexpr double ratio = 16;
  const auto slow = [&](const NoiseModel& n) {
    return SlowNoise{n.K, n.B * std::sqrt(std::log(ratio) / std::numbers::pi), {duration_s, duration_s / ratio, duration_s / (ratio * ratio)}};
  };
  return {gyro, accel, slow(declared.gyro), slow(declared.accel), declared.accel.Q, declared.gyro.Q};
}

BlockSums::BlockSums() {
  gyro.fill(Matrix3d::Zero());
  gyro_velocity.fill(Matrix3d::Zero());
  accel.fill(Matrix3d::Zero());
}

namespace {

void add_to_parts(std::vector<BlockPart>& parts, const ErrorStep& s, const Matrix3d& across) {
  constexpr double little = 0.05;  // rad: the mean of an arc is within 1e-4 of its middle
  if (parts.empty() || parts.back().rate.norm() > little) parts.emplace_back();
  BlockPart& part = parts.back();
  part.twice += across * (s.duration * part.once + s.twice) - s.moved;
  part.once += s.once;
  part.duration += s.duration;
  part.rate += s.duration * s.rate;
  part.force += s.duration * s.force;
}

}  // namespace

void BlockSums::end_parts() {
  double after = duration;
  for (BlockPart& part : parts) {
    after -= part.duration;
    part.force_after = after / duration * force;
  }
}

void BlockSums::add(const ErrorStep& s, const Matrix3d& across, const OptionalSums& optional) {
  if (optional.parts) add_to_parts(parts, s, across);
  const std::array<double, 7> basis{1, s.rate.x(), s.rate.y(), s.rate.z(), s.force.x(), s.force.y(), s.force.z()};
  const std::size_t used = optional.g_sensitivity ? 7 : 4;
  for (std::size_t b = 0; b < used; ++b) {
    gyro_velocity[b].noalias() += across * (s.duration * gyro[b] + basis[b] * s.twice);
    gyro_velocity[b] -= basis[b] * s.moved;
    gyro[b] += basis[b] * s.once;
  }
  duration += s.duration;
  force += s.duration * across;
  accel[0] += s.once;
  for (std::size_t axis = 0; axis < 3; ++axis) accel[axis + 1] += s.with_force[axis];
  if (optional.quadratic) quadratic += s.once * s.force.cwiseAbs2().asDiagonal();
  if (!s.turning) return;
  const auto& [w, f, acceleration] = *s.turning;
  if (optional.delay) {  // uses f' = -w x f and f'' = w x (w x f) - w' x f
    delay += s.once * w.cross(f);
    smear += 0.5 * s.once * (w.cross(w.cross(f)) - acceleration.cross(f));
  }
  if (!optional.lever_arm) return;
  const Matrix3d effect = size_effect(w, acceleration);
  for (Eigen::Index axis = 0; axis < 3; ++axis) lever_arm.middleCols<3>(3 * axis) += s.once.col(axis) * effect.row(axis);
}

Matrix6 BlockSums::by_errors_before(double latitude) const {
  Matrix6 t = Matrix6::Identity();
  t.topLeftCorner<3, 3>() -= duration * skew<double>(earth_rate_enu(latitude));
  t.bottomLeftCorner<3, 3>() = force;
  return t;
}

Errors6 BlockSums::by_coefficient(const Coefficient& c) const {
  const auto input = static_cast<std::size_t>(c.column);
  const auto of_gyro = [&](std::size_t basis) { return (Errors6() << -gyro[basis].col(c.row), -gyro_velocity[basis].col(c.row)).finished(); };
  const auto of_accel = [&](const auto& column) { return (Errors6() << Vector3d::Zero(), column).finished(); };
  switch (c.term) {
    case Term::offset:
      return c.triad == Triad::gyro ? of_gyro(0) : of_accel(accel[0].col(c.row));
    case Term::matrix:
      return c.triad == Triad::gyro ? of_gyro(1 + input) : of_accel(accel[1 + input].col(c.row));
    case Term::g_sensitivity:
      return of_gyro(4 + input);
    case Term::lever_arm:
      return of_accel(lever_arm.col(3 * c.row + c.column));
    default:
      return of_accel(quadratic.col(c.row));
  }
}

Errors6 BlockSums::by_gravity(double gravity) const { return gravity * duration * Errors6::Unit(5); }

Errors6 BlockSums::by_latitude(double latitude) const {
  const Vector3d rate(0, -earth_rate * std::sin(latitude), earth_rate * std::cos(latitude));
  return (Errors6() << duration * rate, 0.5 * duration * (force * rate)).finished();
}

Errors6 BlockSums::by_delay() const { return (Errors6() << Vector3d::Zero(), delay).finished(); }

Errors6 BlockSums::by_smear() const { return (Errors6() << Vector3d::Zero(), smear).finished(); }

Matrix6 BlockSums::covariance(const Noise& noise, const Matrix3d& C) const {
  const Matrix3d of_gyro = C * noise.gyro.cwiseAbs2().asDiagonal() * C.transpose(),
                 of_accel = C * noise.accel.cwiseAbs2().asDiagonal() * C.transpose();
  const double T = duration;
  const Matrix3d across = force / T, moving = skew<double>(Vector3d(path / T));  // [(0, 0, g) x] and [v x], constant within the block
  const Matrix3d cross = ((T * T / 2) * across - T * moving) * of_gyro, mixed = (T * T / 2) * across * of_gyro * moving.transpose();
  Matrix6 q;
  q << T * of_gyro, cross.transpose(), cross,
      T * of_accel + (T * T * T / 3) * across * of_gyro * across.transpose() + T * moving * of_gyro * moving.transpose() - mixed - mixed.transpose();
  return q;
}

BlockSums sums_of(const AttitudeAt& attitude, double begin, double end, double latitude, double gravity) {
  const auto steps = static_cast<int>(std::ceil((end - begin) / 0.05));
  const double h = (end - begin) / steps;
  const Vector3d earth = earth_rate_enu(latitude);
  const Matrix3d across = gravity * skew<double>(Vector3d(Vector3d::UnitZ()));  // [f_n x]
  BlockSums sums;
  for (int k = 0; k < steps; ++k) {
    const double middle = begin + (k + 0.5) * h;
    const Attitude a = attitude(middle);
    const Vector3d w = a.C_nb.transpose() * (a.rate_n + earth), f = gravity * a.C_nb.row(2).transpose();
    ErrorStep step{h, w, f, h * a.C_nb, 0.5 * h * h * a.C_nb, {}};
    for (Eigen::Index axis = 0; axis < 3; ++axis) step.with_force[static_cast<std::size_t>(axis)] = f[axis] * step.once;
    if (!a.rate_n.isZero()) {
      const auto rate_at = [&](double t) {
        const Attitude there = attitude(t);
        return Vector3d(there.C_nb.transpose() * there.rate_n);
      };
      step.turning = {w, f, (rate_at(middle + 0.5 * h) - rate_at(middle - 0.5 * h)) / h};
    }
    sums.add(step, across, {true, true, true, true});
  }
  return sums;
}

}  // namespace imulab::in_place
