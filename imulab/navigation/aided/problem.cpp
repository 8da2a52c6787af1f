#include "imulab/navigation/aided/problem.hpp"

#include "imulab/core/rotation.hpp"
#include "imulab/earth.hpp"
#include "imulab/units.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace imulab::aided {

NavigationState plus(const NavigationState& state, const Eigen::Matrix<double, 9, 1>& error) {
  NavigationState out = state;
  const LocalEarth earth = local_earth(state.latitude, state.height);
  out.q_nb = Eigen::Quaterniond(rotation_exp(error.segment<3>(At::attitude))) * state.q_nb;
  out.q_nb.normalize();
  out.velocity += error.segment<3>(At::velocity);
  out.longitude += error[At::position] / (earth.transverse_radius * earth.cos_latitude);
  out.latitude += error[At::position + 1] / earth.meridian_radius;
  out.height += error[At::position + 2];
  return out;
}

FullState plus(const FullState& state, const Eigen::VectorXd& error) {
  FullState out{plus(state.motion, error.head<9>()), state.x + error};
  out.x.head<9>().setZero();
  return out;
}

std::size_t motion_kind(const NavigationState& a, const NavigationState& b, double seconds) {
  constexpr double slow_mps = 0.3, turning = 5 * unit::deg, accelerating_mps2 = 0.5;
  if (a.q_nb.angularDistance(b.q_nb) > turning * seconds) return 2;
  if ((b.velocity - a.velocity).norm() > accelerating_mps2 * seconds) return 3;
  return a.velocity.norm() < slow_mps ? 0 : 1;
}

NavigationState at_place(const Vector3d& place) {
  NavigationState s;
  s.latitude = place.x(), s.longitude = place.y(), s.height = place.z();
  return s;
}

Eigen::Matrix<double, 9, 1> minus(const NavigationState& to, const NavigationState& from) {
  const LocalEarth earth = local_earth(from.latitude, from.height);
  Eigen::Matrix<double, 9, 1> error;
  error.segment<3>(At::attitude) = rotation_log((to.q_nb * from.q_nb.conjugate()).toRotationMatrix());
  error.segment<3>(At::velocity) = to.velocity - from.velocity;
  error.segment<3>(At::position) << std::remainder(to.longitude - from.longitude, 2 * std::numbers::pi) * earth.transverse_radius *
                                        earth.cos_latitude,
      (to.latitude - from.latitude) * earth.meridian_radius, to.height - from.height;
  return error;
}

DelayedSample delayed_sample(const Problem& p, std::size_t i, const Eigen::VectorXd& x) {
  DelayedSample out{p.samples[i]};
  if (p.gyro_delay < 0) return out;
  const double length = out.sample.interval;
  const auto angle = [&](double place) {
    const TimedIncrement there = p.samples[static_cast<std::size_t>(std::clamp(place, 0., static_cast<double>(p.samples.size() - 1)))];
    return Vector3d((p.samples.angles_recorded() ? 1 : length / there.interval) * there.increment.angle);
  };
  const double later = x[p.gyro_delay] / p.interval, whole = std::floor(later), first = static_cast<double>(i) + whole;
  const Vector3d before = whole == 0 ? out.sample.increment.angle : angle(first), change = angle(first + 1) - before;
  if (later != 0) out.sample.increment.angle = before + (later - whole) * change;
  out.angle_slope = change / p.interval;
  return out;
}

Increment corrected(const Problem& p, const TimedIncrement& sample, const Eigen::VectorXd& x) {
  const Vector3d &angle = sample.increment.angle, &velocity = sample.increment.velocity;
  Increment out{angle + sample.interval * x.segment<3>(p.gyro_offset), velocity + sample.interval * x.segment<3>(p.accel_offset)};
  if (p.gyro_flicker >= 0) out.angle += sample.interval * x.segment<3>(p.gyro_flicker);
  if (p.accel_flicker >= 0) out.velocity += sample.interval * x.segment<3>(p.accel_flicker);
  const auto matrix = [&](Eigen::Index first) { return Eigen::Map<const Matrix3d>(x.data() + first); };  // column by column
  if (p.gyro_matrix >= 0) out.angle += matrix(p.gyro_matrix) * angle;
  if (p.g_sensitivity >= 0) out.angle += matrix(p.g_sensitivity) * velocity;
  if (p.accel_matrix >= 0) out.velocity += matrix(p.accel_matrix) * velocity;
  return out;
}

double delay_at(const Problem& p, const Channel& c, const Eigen::VectorXd& x, double stamp) {
  return c.delay >= 0 ? x[c.delay] + x[c.delay + 1] * (stamp - p.delay_time()) : 0;
}

Vector3d earth_rate_at(const Problem& p, const FullState& state) {
  return p.earth_rate >= 0 ? Vector3d(state.x.segment<3>(p.earth_rate)) : local_earth(state.motion.latitude, state.motion.height).rate;
}

std::string in_words(std::string name) {
  std::ranges::replace(name, '.', ' ');
  std::ranges::replace(name, '_', ' ');
  return name;
}

bool is_result(const Problem& p, const StateBlock& b) { return !std::isfinite(b.time) && b.first != p.earth_rate; }

Eigen::Index add_block(Problem& problem, StateBlock block) {
  block.first = problem.size;
  problem.size += block.size;
  problem.blocks.push_back(std::move(block));
  return problem.blocks.back().first;
}

}  // namespace imulab::aided
