// A three-axis table with its errors (Zhang 2010; docs/theory/turntable.md), for any scalar: with AutoDiffScalar of Eigen every result comes with its
// derivatives. At zero angles the body frame is east-north-up; the outer axis points up, the middle axis north, the inner axis east.
#pragma once

#include "imulab/core/rotation.hpp"
#include "imulab/eigen.hpp"
#include "imulab/recording/turn.hpp"
#include "imulab/session.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>

namespace imulab {

/// Six small angles by RigAxis: (o1, o2), (m1, m2), (i1, i2), rad.
template <class T>
using Orthogonality = std::array<std::array<T, 2>, 3>;

/// Unit vectors of the axes in the table's frame at zero angles, by RigAxis: (o1, o2, 1), (m1, 1, m2), (1, i1, i2), normalized.
template <class T>
using TableAxes = std::array<Eigen::Vector3<T>, 3>;

template <class T>
TableAxes<T> table_axes(const Orthogonality<T>& errors) {
  using std::sqrt;
  const auto& [o, m, i] = errors;
  TableAxes<T> axes{Eigen::Vector3<T>(o[0], o[1], T(1)), Eigen::Vector3<T>(m[0], T(1), m[1]), Eigen::Vector3<T>(T(1), i[0], i[1])};
  for (auto& axis : axes) axis /= sqrt(axis.squaredNorm());
  return axes;
}

/// v turned by the angle whose cosine and sine are given about the unit vector `axis`.
template <class T>
inline Eigen::Vector3<T> turned(const Eigen::Vector3<T>& axis, const T& cosine, const T& sine, const Eigen::Vector3<T>& v) {
  const T part = axis.dot(v) * (1.0 - cosine);
  return {v.x() * cosine + (axis.y() * v.z() - axis.z() * v.y()) * sine + axis.x() * part,
          v.y() * cosine + (axis.z() * v.x() - axis.x() * v.z()) * sine + axis.y() * part,
          v.z() * cosine + (axis.x() * v.y() - axis.y() * v.x()) * sine + axis.z() * part};
}

/// The state of a table: its axes, and the cosines and sines of their actual angles (errors included) by RigAxis.
template <class T>
struct TablePose {
  TableAxes<T> axes;
  std::array<T, 3> cosine, sine;
};

template <class T>
TablePose<T> table_pose(const TableAxes<T>& axes, const std::array<T, 3>& angles) {
  using std::cos, std::sin;
  return {axes, {cos(angles[0]), cos(angles[1]), cos(angles[2])}, {sin(angles[0]), sin(angles[1]), sin(angles[2])}};
}

/// C_bt v: a vector of the table's frame in body axes.
template <class T>
Eigen::Vector3<T> seen_in_body(const TablePose<T>& pose, const Eigen::Vector3<T>& v) {
  Eigen::Vector3<T> out = v;
  for (std::size_t a = 0; a < 3; ++a) out = turned<T>(pose.axes[a], pose.cosine[a], -pose.sine[a], out);
  return out;
}

/// The unit vector of an axis in b: an axis is fixed in the frame that it carries, and turned back by the axes inside it.
template <class T>
Eigen::Vector3<T> axis_in_body(const TablePose<T>& pose, RigAxis axis) {
  const auto own = static_cast<std::size_t>(axis);
  Eigen::Vector3<T> out = pose.axes[own];
  for (std::size_t a = own + 1; a < 3; ++a) out = turned<T>(pose.axes[a], pose.cosine[a], -pose.sine[a], out);
  return out;
}

/// C_nt of a table tilted by these angles [rad]: R(north, about_north) R(east, about_east).
inline Matrix3d table_tilt(double about_east, double about_north) {
  return rotation_about(Vector3d::UnitY(), about_north) * rotation_about(Vector3d::UnitX(), about_east);
}

/// C_tn of a tilted table, by the cosines and sines of its angles about east and north.
template <class T>
struct TableTilt {
  T cosine_east, sine_east, cosine_north, sine_north;
};

template <class T>
TableTilt<T> table_tilt_of(const T& about_east, const T& about_north) {
  using std::cos, std::sin;
  return {cos(about_east), sin(about_east), cos(about_north), sin(about_north)};
}

/// C_tn v = R(east, -about_east) R(north, -about_north) v: a vector of n in the axes of the tilted table.
template <class T>
Eigen::Vector3<T> seen_by_table(const TableTilt<T>& tilt, const Eigen::Vector3<T>& v) {
  const T up = tilt.sine_north * v.x() + tilt.cosine_north * v.z();
  return {tilt.cosine_north * v.x() - tilt.sine_north * v.z(), tilt.cosine_east * v.y() + tilt.sine_east * up,
          tilt.cosine_east * up - tilt.sine_east * v.y()};
}

/// The rate of a rotate step: a trapezoid that lasts `duration` [s], each ramp a fraction of it.
struct TurnProfile {
  double duration = 0, ramp = 0;
};

/// With an acceleration the turn starts at once and waits at its end; without, its ramps fill the step's time.
inline TurnProfile turn_profile(const Step& step) {
  const double available = step.end - step.start, way = std::abs(step.angle);
  if (step.acceleration) {
    const double duration = std::min(available, turn_duration(way, step.rate, *step.acceleration));
    const double ramp = std::min(step.rate, std::sqrt(way * *step.acceleration)) / *step.acceleration;
    return {duration, std::min(0.5, ramp / duration)};
  }
  return {available, std::clamp(1 - way / (step.rate * available), 0.0, 0.5)};
}

/// Integrals over the turn of the cosine and the sine of the angle turned so far; `angle` is not zero.
template <class T>
std::array<T, 2> turn_integrals(const T& angle, const T& duration, double ramp) {
  using std::abs, std::cos, std::sin;
  // The first ramp turns by `angle` x part x (u / ramp)^2, u = t / duration. Five Gauss-Legendre nodes for every half radian: 1e-15.
  constexpr std::array<double, 5> node{-0.90617984593866399280, -0.53846931010568309104, 0, 0.53846931010568309104, 0.90617984593866399280};
  constexpr std::array<double, 5> weight{0.23692688505618908751, 0.47862867049936646804, 0.56888888888888888889, 0.47862867049936646804,
                                         0.23692688505618908751};
  const double part = 0.5 * ramp / (1 - ramp);
  T c(0), s(0);
  if (ramp > 0) {
    double turned_by;
    if constexpr (std::is_same_v<T, double>)
      turned_by = std::abs(angle) * part;
    else
      turned_by = std::abs(angle.value()) * part;
    const int panels = std::max(1, static_cast<int>(std::ceil(2 * turned_by / 0.5)));
    for (int k = 0; k < panels; ++k)
      for (std::size_t n = 0; n < node.size(); ++n) {
        const double x = (k + 0.5 + 0.5 * node[n]) / panels;
        const T phi = angle * (part * x * x);
        c += cos(phi) * (0.5 * weight[n] * ramp / panels);
        s += sin(phi) * (0.5 * weight[n] * ramp / panels);
      }
  }
  const T whole_c = cos(angle), whole_s = sin(angle);
  const T from = angle * part, to = angle - from;  // at constant rate
  const T cruise_c = (sin(to) - sin(from)) * (1 - ramp) / angle, cruise_s = (cos(from) - cos(to)) * (1 - ramp) / angle;
  // The second ramp is the first one mirrored: angle - phi.
  return {duration * (c + cruise_c + whole_c * c + whole_s * s), duration * (s + cruise_s + whole_s * c - whole_c * s)};
}

/// A turn about one axis, in between rests: from `before` seconds before its begin to `after` seconds after its end.
template <class T>
struct TurnInterval {
  Eigen::Vector3<T> axis_b;   ///< constant in b while the table turns about it
  T angle;                    ///< actual, rad
  T before, duration, after;  ///< s
  double ramp;                ///< fraction of the duration
};

/// Integral over the whole interval of C_bn v; `at_start` is C_bn v before the turn.
template <class T>
Eigen::Vector3<T> integral_in_body(const TurnInterval<T>& turn, const Eigen::Vector3<T>& at_start) {
  using std::cos, std::sin;
  const auto [c, s] = turn_integrals<T>(turn.angle, turn.duration, turn.ramp);
  const Eigen::Vector3<T> along = turn.axis_b * turn.axis_b.dot(at_start);
  const Eigen::Vector3<T> moving = along * turn.duration + (at_start - along) * c - turn.axis_b.cross(at_start) * s;
  return at_start * turn.before + moving + turned<T>(turn.axis_b, cos(turn.angle), -sin(turn.angle), at_start) * turn.after;
}

}  // namespace imulab
