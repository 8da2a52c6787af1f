#include "imulab/navigation/motion/trajectory.hpp"

#include "imulab/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace imulab::motion {
namespace {

/// Returns the integral of rate and force from `begin` to `end`, between which all derivatives exist.
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

/// Returns the integrals over a longer time, in parts over which the trajectory is smooth.
Increment smooth_parts(const Trajectory& trajectory, double begin, double end) {
  const double parts = std::max(1., std::ceil((end - begin) / trajectory.smooth * (1 - 1e-12)));
  Increment sum;
  for (double i = 0; i < parts; ++i) {
    const Increment part = smooth_increment(trajectory, begin + (end - begin) * i / parts, begin + (end - begin) * (i + 1) / parts);
    sum.angle += part.angle;
    sum.velocity += part.velocity;
  }
  return sum;
}

/// Returns the number of whole intervals in a trajectory.
std::size_t interval_count(const Trajectory& trajectory, double interval) {
  if (!(interval > 0)) throw Error(fmt::format("sampling interval {} s: expected a positive number", interval));
  return static_cast<std::size_t>(std::floor(trajectory.duration / interval * (1 + 1e-12)));
}

}  // namespace

BodyMotion body_motion(const Kinematics& k) {
  const LocalEarth earth = local_earth(k.latitude, k.height);
  const Eigen::Vector3d transport = earth.transport_rate(k.velocity);
  const Eigen::Matrix3d C_bn = k.C_nb.transpose();
  return {k.rate_nb_b + C_bn * (earth.rate + transport), C_bn * (k.acceleration + (2 * earth.rate + transport).cross(k.velocity) - earth.gravity)};
}

std::vector<Increment> ideal_increments(const Trajectory& trajectory, double interval, const std::function<void(std::uint64_t)>& progress) {
  std::vector<Increment> out(interval_count(trajectory, interval));
  std::vector<double> breaks = trajectory.breaks;
  std::sort(breaks.begin(), breaks.end());
  auto next = breaks.begin();
  for (std::size_t i = 0; i < out.size(); ++i) {
    double from = static_cast<double>(i) * interval;
    const double end = std::min(static_cast<double>(i + 1) * interval, trajectory.duration);
    const auto add = [&](double to) {
      const Increment part = smooth_parts(trajectory, from, to);
      out[i].angle += part.angle;
      out[i].velocity += part.velocity;
      from = to;
    };
    while (next != breaks.end() && *next <= from) ++next;
    for (; next != breaks.end() && *next < end; ++next) add(*next);
    add(end);
    if (progress && (i + 1) % 10000 == 0) progress(i + 1);
  }
  return out;
}

NavigationState navigation_state(const Kinematics& k) {
  NavigationState state;
  state.q_nb = Eigen::Quaterniond(k.C_nb);
  state.velocity = k.velocity;
  state.latitude = k.latitude;
  state.longitude = k.longitude;
  state.height = k.height;
  return state;
}

Solution truth(const Trajectory& trajectory, double interval, std::size_t every) {
  const std::size_t count = interval_count(trajectory, interval);
  Solution out;
  for (std::size_t i = 0; i <= count; ++i) {
    if (i % every != 0 && i != count) continue;
    out.time.push_back(static_cast<double>(i) * interval);
    out.states.push_back(navigation_state(trajectory.at(std::min(out.time.back(), trajectory.duration))));
  }
  return out;
}

NominalMotion nominal_motion(const Trajectory& trajectory, double interval) {
  NominalMotion out;
  out.increments = ideal_increments(trajectory, interval);
  const std::size_t count = out.increments.size();
  out.time.reserve(count + 1);
  out.states.reserve(count + 1);
  for (std::size_t i = 0; i <= count; ++i) {
    out.time.push_back(std::min(static_cast<double>(i) * interval, trajectory.duration));
    out.states.push_back(navigation_state(trajectory.at(out.time.back())));
  }
  return out;
}

}  // namespace imulab::motion
