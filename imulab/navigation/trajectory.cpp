#include "imulab/navigation/trajectory.hpp"

#include "imulab/core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace imulab {
namespace {

/// Integral of rate and force from `begin` to `end`, where all derivatives exist.
Increment smooth_increment(const Trajectory& trajectory, double begin, double end) {
  static constexpr std::array<double, 2> node{0.33998104358485626, 0.86113631159405258}, weight{0.65214515486254614, 0.34785484513745386};
  const double middle = (begin + end) / 2, half = (end - begin) / 2;
  Increment sum;
  for (std::size_t i = 0; i < 2; ++i)
    for (double side : {-1., 1.}) {
      const BodyMotion motion = body_motion(trajectory.at(middle + side * half * node[i]));
      sum.angle += half * weight[i] * motion.rate_ib_b;
      sum.velocity += half * weight[i] * motion.force_b;
    }
  return sum;
}

}  // namespace

BodyMotion body_motion(const Kinematics& k) {
  const LocalEarth earth = local_earth(k.latitude, k.height);
  const Eigen::Vector3d transport = earth.transport_rate(k.velocity);
  const Eigen::Matrix3d C_bn = attitude_matrix(k.angles).transpose();
  return {attitude_rate(k.angles, k.angle_rates) + C_bn * (earth.rate + transport),
          C_bn * (k.acceleration + (2 * earth.rate + transport).cross(k.velocity) - earth.gravity)};
}

std::vector<Increment> ideal_increments(const Trajectory& trajectory, double interval) {
  if (!(interval > 0)) throw Error(fmt::format("sampling interval {} s: expected a positive number", interval));
  const auto count = static_cast<std::size_t>(std::floor(trajectory.duration / interval * (1 + 1e-12)));
  std::vector<double> breaks = trajectory.breaks;
  std::sort(breaks.begin(), breaks.end());
  std::vector<Increment> out(count);
  auto next = breaks.begin();
  for (std::size_t i = 0; i < count; ++i) {
    double from = static_cast<double>(i) * interval;
    const double end = std::min(static_cast<double>(i + 1) * interval, trajectory.duration);
    while (next != breaks.end() && *next <= from) ++next;
    for (; next != breaks.end() && *next < end; ++next) {
      const Increment part = smooth_increment(trajectory, from, *next);
      out[i].angle += part.angle;
      out[i].velocity += part.velocity;
      from = *next;
    }
    const Increment part = smooth_increment(trajectory, from, end);
    out[i].angle += part.angle;
    out[i].velocity += part.velocity;
  }
  return out;
}

NavigationState navigation_state(const Kinematics& k) {
  NavigationState state;
  state.q_nb = Eigen::Quaterniond(attitude_matrix(k.angles));
  state.velocity = k.velocity;
  state.latitude = k.latitude;
  state.longitude = k.longitude;
  state.height = k.height;
  return state;
}

}  // namespace imulab
