#include "imulab/navigation/aided/observation.hpp"

#include "imulab/core/rotation.hpp"
#include "imulab/earth.hpp"
#include "imulab/navigation/aided/observed_point.hpp"
#include "imulab/navigation/aided/pose.hpp"
#include "imulab/units.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace imulab::aided {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Returns the value of each axis if the row states it, else `otherwise`.
Vector3d stated_or(const std::vector<Vector3d>& rows, std::size_t row, double otherwise) {
  Vector3d out = Vector3d::Constant(otherwise);
  for (Eigen::Index k = 0; row < rows.size() && k < 3; ++k)
    if (std::isfinite(rows[row][k]) && rows[row][k] > 0) out[k] = rows[row][k];
  return out;
}

ObservedRows observe_position(const Problem& p, const Channel& c, const Observation& o, const Instant& at, const Vector3d& place) {
  const Matrix3d C = at.state.motion.q_nb.toRotationMatrix();
  const Vector3d moved = C * lever_of(c, at), acceleration = acceleration_of(c, at);
  const Derived velocity = velocity_of(p, c, at);
  const double offset = offset_in_time(p, c, o, at);
  ObservedRows out = rows_of(3, p.size);
  out.residual =
      minus(at_place(place), at.state.motion).segment<3>(At::position) - moved - offset * velocity.value - offset * offset / 2 * acceleration;
  out.derivative = offset * velocity.derivative;
  out.derivative.middleCols<3>(At::attitude) -= skew<double>(moved);
  out.derivative.middleCols<3>(At::position).setIdentity();
  if (c.lever >= 0) out.derivative.middleCols<3>(c.lever) += C;
  set_delay(p, c, o, velocity.value + offset * acceleration, out.derivative);
  if (c.slow >= 0) out.residual -= at.state.x.segment<3>(c.slow), out.derivative.middleCols<3>(c.slow).setIdentity();
  if (c.level >= 0) out.residual[2] -= at.state.x[c.level], out.derivative(2, c.level) = 1;
  out.variance = position_sigma(c.aid, o.row).cwiseAbs2();
  std::ranges::fill(out.source, c.first_noise);
  return out;
}

ObservedRows observe_velocity(const Problem& p, const Channel& c, const Observation& o, const Instant& at, const Vector3d& measured) {
  const Vector3d acceleration = acceleration_of(c, at);
  const Derived velocity = velocity_of(p, c, at);
  ObservedRows out = rows_of(3, p.size);
  out.residual = measured - velocity.value - offset_in_time(p, c, o, at) * acceleration;
  out.derivative = velocity.derivative;
  set_delay(p, c, o, acceleration, out.derivative);
  out.variance = velocity_sigma(c.aid, o.row).cwiseAbs2();
  std::ranges::fill(out.source, c.second_noise);
  return out;
}

ObservedRows observe_gnss(const Problem& p, const Channel& c, const Observation& o, const Instant& at) {
  const AidRecord& r = c.aid.record;
  ObservedRows out = rows_of(0, p.size);
  if (!r.position.empty() && !r.position[o.row].hasNaN()) out = joined_rows(out, observe_position(p, c, o, at, r.position[o.row]));
  if (!r.velocity.empty()) out = joined_rows(out, observe_velocity(p, c, o, at, r.velocity[o.row]));
  return out;
}

/// Returns the velocity of the vehicle's point in vehicle axes.
Derived vehicle_velocity(const Problem& p, const Channel& c, const Instant& at) {
  const Matrix3d C_bn = at.state.motion.q_nb.toRotationMatrix().transpose(), R = mounting(p, c, at.state.x);
  const Derived swing = swing_of(p, c, at);
  Derived out{R * (C_bn * at.state.motion.velocity + swing.value), R * swing.derivative};
  out.derivative.middleCols<3>(At::attitude) += R * C_bn * skew<double>(at.state.motion.velocity);
  out.derivative.middleCols<3>(At::velocity) = R * C_bn;
  if (c.mount >= 0) {
    const double yaw = at.state.x[c.mount + 1];
    out.derivative.col(c.mount) =
        rotation_about(Vector3d::UnitZ(), yaw) * Vector3d::UnitX().cross(rotation_about(Vector3d::UnitZ(), -yaw) * out.value);
    out.derivative.col(c.mount + 1) = Vector3d::UnitZ().cross(out.value);
  }
  return out;
}

ObservedRows observe_vehicle(const Problem& p, const Channel& c, const Observation& o, const Instant& at) {
  const Derived v = vehicle_velocity(p, c, at);
  ObservedRows out = rows_of(2, p.size);
  for (Eigen::Index k = 0; k < 2; ++k) {
    out.residual[k] = -v.value[2 * k] - (c.slow >= 0 ? at.state.x[c.slow + k] : 0);
    out.derivative.row(k) = v.derivative.row(2 * k);
    if (c.slow >= 0) out.derivative(k, c.slow + k) = 1;
  }
  out.variance.setConstant(std::pow(value_sigma(c.aid, o.row), 2));
  out.source = {c.first_noise, c.second_noise};
  return out;
}

ObservedRows observe_wheels(const Problem& p, const Channel& c, const Observation& o, const Instant& at) {
  const Derived v = vehicle_velocity(p, c, at);
  const double scale = 1 + (c.scale >= 0 ? at.state.x[c.scale] : 0);
  ObservedRows out = rows_of(1, p.size);
  const Matrix3d R = mounting(p, c, at.state.x);
  const Vector3d sensed = at.state.motion.q_nb.conjugate() * acceleration_of(c, at) - at.rate_eb.cross(R.transpose() * v.value);  // in rotating axes
  const VectorXd rate = VectorXd::Constant(1, scale * (R * sensed).y());
  out.residual[0] = c.aid.record.value[o.row] - scale * v.value.y() - offset_in_time(p, c, o, at) * rate[0];
  out.derivative.row(0) = scale * v.derivative.row(1);
  if (c.scale >= 0) out.derivative(0, c.scale) = v.value.y();
  if (c.slow >= 0) out.residual[0] -= at.state.x[c.slow], out.derivative(0, c.slow) = 1;
  set_delay(p, c, o, rate, out.derivative);
  out.variance[0] = std::pow(value_sigma(c.aid, o.row), 2);
  out.source[0] = c.first_noise;
  return out;
}

ObservedRows observe_barometer(const Problem& p, const Channel& c, const Observation& o, const Instant& at) {
  const double offset = offset_in_time(p, c, o, at);
  const Matrix3d C = at.state.motion.q_nb.toRotationMatrix();
  const Vector3d moved = C * lever_of(c, at);
  const Derived velocity = velocity_of(p, c, at);
  ObservedRows out = rows_of(1, p.size);
  out.residual[0] = c.aid.record.value[o.row] - at.state.motion.height - moved.z() - offset * velocity.value.z();
  out.derivative = offset * velocity.derivative.row(2);
  out.derivative(0, At::position + 2) = 1;
  out.derivative.block<1, 3>(0, At::attitude) -= skew<double>(moved).row(2);
  if (c.lever >= 0) out.derivative.block<1, 3>(0, c.lever) += C.row(2);
  if (c.slow >= 0) out.residual[0] -= at.state.x[c.slow], out.derivative(0, c.slow) = 1;
  set_delay(p, c, o, velocity.value.tail<1>(), out.derivative);
  out.variance[0] = std::pow(value_sigma(c.aid, o.row), 2);
  out.source[0] = c.first_noise;
  return out;
}

ObservedRows observe_heading(const Problem& p, const Channel& c, const Observation& o, const Instant& at) {
  const double offset = offset_in_time(p, c, o, at);
  const Matrix3d C = at.state.motion.q_nb.toRotationMatrix();
  const double east = C(0, 1), north = C(1, 1), up = C(2, 1), level = east * east + north * north;
  ObservedRows out = rows_of(1, p.size);
  const VectorXd rate = VectorXd::Constant(1, -(C * at.rate_eb).z());  // rate of heading of a level body
  out.residual[0] = std::remainder(c.aid.record.value[o.row] - std::atan2(east, north) - offset * rate[0], 2 * std::numbers::pi);
  out.derivative = -offset * C.row(2) * rate_derivative(p, at);
  set_delay(p, c, o, rate, out.derivative);
  out.derivative.leftCols<3>() += Eigen::RowVector3d(east * up / level, north * up / level, -1);
  if (c.slow >= 0) out.residual[0] -= at.state.x[c.slow], out.derivative(0, c.slow) = 1;
  out.variance[0] = std::pow(value_sigma(c.aid, o.row), 2);
  out.source[0] = c.first_noise;
  return out;
}

/// The rate at rest is a mean, with the noise of the gyros and of a base that is not quite still.
ObservedRows observe_rest(const Problem& p, const Channel& c, const Observation& o, const Instant& at) {
  ObservedRows out = rows_of(6, p.size);
  out.residual << -at.state.motion.velocity, -at.rate_eb;
  out.derivative.block<3, 3>(0, At::velocity).setIdentity();
  out.derivative.bottomRows<3>() = rate_derivative(p, at);
  if (p.gyro_delay >= 0) out.derivative.col(p.gyro_delay).setZero();  // changes of the rate are noise
  out.variance.head<3>() = velocity_sigma(c.aid, o.row).cwiseAbs2();
  out.variance.tail<3>() = p.gyro_noise.cwiseAbs2() / (2 * std::max(p.half_instant, p.interval)) + Vector3d::Constant(std::pow(2e-4, 2));
  for (std::size_t k = 0; k < 6; ++k) out.source[k] = k < 3 ? c.first_noise : c.second_noise;
  return out;
}

constexpr std::array laws{
    AidLaw{AidKind::gnss, "gnss", 2.5, 0.2, 0, observe_gnss},
    AidLaw{AidKind::vehicle, "vehicle", 0, 0, 0.05, observe_vehicle},
    AidLaw{AidKind::wheels, "wheels", 0, 0, 0.1, observe_wheels},
    AidLaw{AidKind::barometer, "barometer", 0, 0, 1, observe_barometer},
    AidLaw{AidKind::heading, "heading", 0, 0, 2 * unit::deg, observe_heading},
    AidLaw{AidKind::zero_velocity, "zero_velocity", 0, 0.02, 0, observe_rest},
    AidLaw{AidKind::pose, "pose", 0.002, 0, 0.1 * unit::deg, observe_pose},
    AidLaw{AidKind::attitude, "attitude", 0, 0, 0.5 * unit::deg, observe_pose},
    AidLaw{AidKind::odometry, "odometry", 0.01, 0, 0.2 * unit::deg, observe_pose},
};

}  // namespace

ObservedRows observe(const Problem& p, const Observation& o, const Instant& instant) {
  const Channel& channel = p.channels[o.channel];
  ObservedRows all = aid_law(channel.aid.kind).observe(p, channel, o, instant);
  if (all.residual.allFinite()) return all;
  std::vector<Eigen::Index> measured;
  for (Eigen::Index k = 0; k < all.residual.size(); ++k)
    if (std::isfinite(all.residual[k])) measured.push_back(k);
  ObservedRows out{all.residual(measured), all.derivative(measured, Eigen::all), all.variance(measured), {}};
  for (const Eigen::Index k : measured) out.source.push_back(all.source[static_cast<std::size_t>(k)]);
  return out;
}

const AidLaw& aid_law(AidKind kind) { return *std::ranges::find(laws, kind, &AidLaw::kind); }

Vector3d position_sigma(const Aid& aid, std::size_t row) {
  return stated_or(aid.record.position_sigma, row, aid.position_sigma.value_or(aid_law(aid.kind).position_sigma));
}

Vector3d velocity_sigma(const Aid& aid, std::size_t row) {
  return stated_or(aid.record.velocity_sigma, row, aid.velocity_sigma.value_or(aid_law(aid.kind).velocity_sigma));
}

double value_sigma(const Aid& aid, std::size_t row) {
  if (row < aid.record.value_sigma.size() && aid.record.value_sigma[row] > 0) return aid.record.value_sigma[row];
  return aid.value_sigma.value_or(aid_law(aid.kind).value_sigma);
}

Matrix3d mounting(const Problem&, const Channel& c, const Eigen::VectorXd& x) {
  if (c.mount < 0) return Matrix3d::Identity();
  return rotation_about(Vector3d::UnitZ(), x[c.mount + 1]) * rotation_about(Vector3d::UnitX(), x[c.mount]);
}

Instant instant_at(const Problem& p, std::size_t end, const FullState& state) {
  const auto margin = static_cast<std::size_t>(std::max(1., std::round(p.half_instant / p.interval)));
  Increment sum, raw;
  Vector3d before = Vector3d::Zero();
  double length = 0, length_before = 0;
  for (std::size_t i = end > margin ? end - margin : 0; i < std::min(end + margin, p.samples.size()); ++i) {
    if (i == end) before = sum.angle, length_before = length;
    const TimedIncrement read = delayed_sample(p, i, state.x).sample;
    const Increment sample = corrected(p, read, state.x);
    sum.angle += sample.angle, sum.velocity += sample.velocity, length += read.interval;
    raw.angle += read.increment.angle, raw.velocity += read.increment.velocity;
  }
  Vector3d turning = Vector3d::Zero();
  if (const double after = length - length_before; length_before > 0 && after > 0)
    turning = 2 / length * ((sum.angle - before) / after - before / length_before);
  const LocalEarth earth = local_earth(state.motion.latitude, state.motion.height);
  const Matrix3d C = state.motion.q_nb.toRotationMatrix();
  const Vector3d rate = sum.angle / length, &v = state.motion.velocity;
  const Vector3d gravity = p.gravity ? Vector3d(0, 0, -*p.gravity) : earth.gravity;
  return {.state = state,
          .time = end > 0 ? p.time[end - 1] : p.begin,
          .rate_ib = rate,
          .rate_eb = rate - C.transpose() * earth_rate_at(p, state),
          .turning = turning,
          .acceleration = C * sum.velocity / length + gravity - (2 * earth.rate + earth.transport_rate(v)).cross(v),
          .raw_rate = raw.angle / length,
          .raw_force = raw.velocity / length,
          .sample = end > 0 ? end - 1 : 0};
}

}  // namespace imulab::aided
