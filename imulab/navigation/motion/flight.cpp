#include "imulab/navigation/motion/flight.hpp"

#include "imulab/core/rotation.hpp"
#include "imulab/eigen.hpp"
#include "imulab/error.hpp"
#include "imulab/navigation/integration/local_earth.hpp"
#include "imulab/navigation/motion/spline.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>

namespace imulab::motion {
namespace {

struct Controls {
  Derivatives speed, heading, climb;
};

/// A segment with the state at its beginning.
struct Leg {
  Segment segment;
  double speed, heading, climb;
  Matrix3d C_vb;  // rotation from the unit to its carrier
};

struct Node {  // the start of a segment, or a point inside it
  double time, segment_time;
  std::size_t leg;
  Vector3d position;  // latitude, longitude, height, without sway
};

struct FlightPath {
  std::vector<Leg> legs;
  std::vector<Node> nodes;
  bool banks = true;
};

Derivatives from(double begin, const Derivatives& added) { return {begin + added.value, added.first, added.second}; }

Controls controls_at(const Leg& leg, double t) {
  const auto quantity = [&](Pulse::Of of, double begin) { return from(begin, pulses_at(leg.segment, of, t)); };
  return {quantity(Pulse::Of::speed, leg.speed), quantity(Pulse::Of::heading, leg.heading), quantity(Pulse::Of::climb, leg.climb)};
}

Vector3d velocity_of(const Controls& c) {
  const double level = c.speed.value * std::cos(c.climb.value);
  return {level * std::sin(c.heading.value), level * std::cos(c.heading.value), c.speed.value * std::sin(c.climb.value)};
}

Vector3d position_rate(const Vector3d& position, const Vector3d& v) {
  const LocalEarth e = local_earth(position.x(), position.z());
  return {v.y() / e.meridian_radius, v.x() / (e.transverse_radius * e.cos_latitude), v.z()};
}

/// Returns the position after one step of the fourth-order Runge-Kutta method from a node.
Vector3d position_after(const Node& n, const Leg& leg, double h) {
  const auto v = [&](double t) { return velocity_of(controls_at(leg, n.segment_time + t)); };
  const Vector3d middle = v(h / 2);
  const Vector3d a = position_rate(n.position, v(0)), b = position_rate(n.position + h / 2 * a, middle);
  const Vector3d c = position_rate(n.position + h / 2 * b, middle), d = position_rate(n.position + h * c, v(h));
  return n.position + h / 6 * (a + 2 * b + 2 * c + d);
}

/// Returns the roll of a coordinated turn: tan(roll) = V heading' cos(climb) / g.
Derivatives roll_of(const Controls& c, double level_rate) {
  const double level = c.speed.value * std::cos(c.climb.value);
  const double tangent = level * c.heading.first / unit::g, rate = (level_rate * c.heading.first + level * c.heading.second) / unit::g;
  return {std::atan(tangent), rate / (1 + tangent * tangent), 0};
}

/// Adds the displacement of a resting base to position and velocity. The radii are those of the resting place: 1e-8 of the velocity.
void add_displacement(Kinematics& k, const Segment& segment, double t) {
  std::array<Derivatives, 3> d;
  for (int i = 0; i < 3; ++i)
    d[static_cast<std::size_t>(i)] = sway_at(segment.sway.displacement, segment.sway.displacement_frequency, i, segment.duration, t);
  const LocalEarth earth = local_earth(k.latitude, k.height);
  k.latitude += d[1].value / earth.meridian_radius;
  k.longitude += d[0].value / (earth.transverse_radius * earth.cos_latitude);
  k.height += d[2].value;
  k.velocity += Vector3d(d[0].first, d[1].first, d[2].first);
  k.acceleration += Vector3d(d[0].second, d[1].second, d[2].second);
}

Kinematics kinematics(const Vector3d& position, const Leg& leg, double t, bool banks) {
  const Controls c = controls_at(leg, t);
  const Segment& segment = leg.segment;
  Kinematics k;
  k.latitude = position.x();
  k.longitude = position.y();
  k.height = position.z();
  k.velocity = velocity_of(c);
  const double V = c.speed.value, cg = std::cos(c.climb.value), sg = std::sin(c.climb.value);
  const double level_rate = c.speed.first * cg - V * sg * c.climb.first, sh = std::sin(c.heading.value), ch = std::cos(c.heading.value);
  k.acceleration = {level_rate * sh + k.velocity.y() * c.heading.first, level_rate * ch - k.velocity.x() * c.heading.first,
                    c.speed.first * sg + V * cg * c.climb.first};
  if (segment.sway.displacement != 0) add_displacement(k, segment, t);

  // Attitude of the carrier (v), then of the unit in it: C_nb = C_nv C_vb.
  const auto sway = [&](int i) { return sway_at(segment.sway.angle, segment.sway.angle_frequency, i, segment.duration, t); };
  const Derivatives banked = banks ? roll_of(c, level_rate) : Derivatives{};
  const Derivatives roll = from(banked.value, sway(0)), pitch = from(c.climb.value, sway(1)), heading = from(c.heading.value, sway(2));
  const EulerAngles angles{roll.value, pitch.value, heading.value};
  const EulerAngles rates{banked.first + roll.first, c.climb.first + pitch.first, c.heading.first + heading.first};
  const Derivatives table = pulses_at(segment, Pulse::Of::table, t);
  const Matrix3d C_vb = leg.C_vb * rotation_about(segment.table_axis, table.value);
  k.C_nb = attitude_matrix(angles) * C_vb;
  k.rate_nb_b = C_vb.transpose() * attitude_rate(angles, rates) + table.first * segment.table_axis;
  return k;
}

/// Returns the distance of the nodes: at most 0.1 s and 1/25 of the shortest ramp of the position; a step at 30 g then has an error of a micrometer.
double node_interval(const Segment& s) {
  double shortest = 2.5;
  for (const Pulse& p : s.pulses)
    if (p.of != Pulse::Of::table) shortest = std::min(shortest, p.ramp);
  return std::max(shortest / 25, s.duration / 1e5);
}

/// Adds the nodes of a segment and returns the node at its end.
Node lay_out(FlightPath& motion, Node node) {
  const Leg& leg = motion.legs[node.leg];
  const double begin = node.time, duration = leg.segment.duration;
  const auto steps = static_cast<std::size_t>(std::ceil(duration / std::min(0.1, node_interval(leg.segment))));
  for (std::size_t k = 0; k < steps; ++k) {
    motion.nodes.push_back(node);
    const double next = duration * static_cast<double>(k + 1) / static_cast<double>(steps);
    node.position = position_after(node, leg, next - node.segment_time);
    node.segment_time = next;
    node.time = begin + next;
    integration::expect_latitude(node.position.x());
  }
  return {node.time, 0, node.leg + 1, node.position};
}

/// Returns the instants of a segment at which a third derivative jumps.
std::vector<double> breaks_of(const Segment& s) {
  std::vector<double> out{s.duration};
  for (const Pulse& p : s.pulses) out.insert(out.end(), {p.begin, p.begin + p.ramp, p.begin + p.ramp + p.hold, p.end()});
  if (s.sway.angle != 0 || s.sway.displacement != 0) out.insert(out.end(), {sway_ramp(s.duration), s.duration - sway_ramp(s.duration)});
  return out;
}

/// Returns the time per radian of the fastest vibration or rotation, for which four-point quadrature has a relative error of 1e-9.
double smooth_time(const Segment& s, double longest) {
  const double turn = 2 * std::numbers::pi;
  double fastest = 1 / longest;  // rad/s
  if (s.sway.angle != 0) fastest = std::max(fastest, turn * s.sway.angle_frequency);
  if (s.sway.displacement != 0) fastest = std::max(fastest, turn * s.sway.displacement_frequency);
  for (const Pulse& p : s.pulses)
    if (p.of == Pulse::Of::table || p.of == Pulse::Of::heading) fastest = std::max(fastest, std::abs(p.rate()));
  return 1 / fastest;
}

}  // namespace

Trajectory flight(const FlightStart& start, const std::vector<Segment>& segments, const Carrier& carrier) {
  if (segments.empty()) throw Error("a motion: expected at least one segment");
  if (!std::isfinite(start.latitude + start.longitude + start.height + start.speed + start.heading + start.climb) || start.speed < 0)
    throw Error("start of a motion: expected finite numbers and a speed of 0 or more");
  integration::expect_latitude(start.latitude);
  const auto motion = std::make_shared<FlightPath>();
  motion->banks = carrier.banks;
  Trajectory out;
  Node node{0, 0, 0, {start.latitude, start.longitude, start.height}};
  Leg next{{}, start.speed, start.heading, start.climb, Matrix3d::Identity()};
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const Segment& s = segments[i];
    try {
      check_segment(s, next.speed, carrier);
      next.segment = s;
      motion->legs.push_back(next);
      for (const double t : breaks_of(s)) out.breaks.push_back(node.time + t);
      node = lay_out(*motion, node);
    } catch (const Error& e) {
      throw Error(fmt::format("segment {}: {}", i + 1, e.what()));
    }
    next.speed += s.change(Pulse::Of::speed);
    next.heading += s.change(Pulse::Of::heading);
    next.climb += s.change(Pulse::Of::climb);
    next.C_vb = next.C_vb * rotation_about(s.table_axis, s.change(Pulse::Of::table));
    out.smooth = smooth_time(s, out.smooth);
  }
  out.duration = node.time;
  out.at = [motion](double t) {
    const auto& nodes = motion->nodes;
    const auto after = std::upper_bound(nodes.begin() + 1, nodes.end(), t, [](double a, const Node& n) { return a < n.time; });
    const Node& n = *(after - 1);
    const Leg& leg = motion->legs[n.leg];
    const double h = t - n.time;
    return kinematics(position_after(n, leg, h), leg, n.segment_time + h, motion->banks);
  };
  return out;
}

namespace {

using Eigen::Matrix3d, Eigen::Vector3d, Eigen::Vector4d;
using Eigen::Quaterniond;

void check(const Solution& rows) {
  if (rows.size() < 4) throw Error(fmt::format("track: {} row{}, expected at least 4", rows.size(), rows.size() == 1 ? "" : "s"));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const NavigationState& s = rows.states[i];
    const auto refuse = [&](const std::string& what) { throw Error(fmt::format("track at {:.3f} s: {}", rows.time[i], what)); };
    if (!std::isfinite(rows.time[i] + s.latitude + s.longitude + s.height) || !s.q_nb.coeffs().allFinite()) refuse("expected finite numbers");
    if (i > 0 && !(rows.time[i] > rows.time[i - 1])) refuse("time does not ascend");
    try {
      integration::expect_latitude(s.latitude);
    } catch (const Error& e) {
      refuse(e.what());
    }
    const double turned = i > 0 ? s.q_nb.angularDistance(rows.states[i - 1].q_nb) : 0;
    if (turned >= 90 * unit::deg)
      refuse(fmt::format("the attitude is {:.0f} deg from the row before, expected less than 90: rows closer in time", turned / unit::deg));
  }
}

/// Splines in meters east, north, up of the first row, a common unit; the longitude continues across 180 deg.
struct Splines {
  Splines(const Solution& rows, const TrackSmoothing& smoothing);
  Kinematics at(double t) const;

  double latitude, longitude, height;  // position of the first row
  double east_radius, north_radius;    // m per radian
  std::unique_ptr<Spline<3>> position;
  std::unique_ptr<Spline<4>> attitude;  // spline of the quaternion's components before normalization
};

template <int N>
std::unique_ptr<Spline<N>> spline(const std::vector<double>& knots, const std::vector<typename Spline<N>::Point>& points, double mean_square) {
  return std::make_unique<Spline<N>>(mean_square > 0 ? Spline<N>::smoothing(knots, points, mean_square) : Spline<N>(knots, points));
}

Splines::Splines(const Solution& rows, const TrackSmoothing& smoothing) {
  const NavigationState& first = rows.states.front();
  const LocalEarth earth = local_earth(first.latitude, first.height);
  latitude = first.latitude, longitude = first.longitude, height = first.height;
  east_radius = earth.transverse_radius * earth.cos_latitude, north_radius = earth.meridian_radius;
  std::vector<double> knots;
  std::vector<Vector3d> points;
  std::vector<Vector4d> quaternions;
  double eastwards = 0;  // rad
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const NavigationState& s = rows.states[i];
    if (i > 0) eastwards += std::remainder(s.longitude - rows.states[i - 1].longitude, 2 * std::numbers::pi);
    knots.push_back(rows.time[i] - rows.time.front());
    points.emplace_back(eastwards * east_radius, (s.latitude - latitude) * north_radius, s.height - height);
    const Vector4d q = s.q_nb.normalized().coeffs();
    quaternions.push_back(i > 0 && q.dot(quaternions.back()) < 0 ? Vector4d(-q) : q);
  }
  position = spline<3>(knots, points, 3 * smoothing.position * smoothing.position);
  attitude = spline<4>(knots, quaternions, 0.75 * smoothing.attitude * smoothing.attitude);  // a rotation by d changes a quaternion by d/2
}

Kinematics Splines::at(double t) const {
  const auto p = position->at(t);
  const double latitude_rate = p.first.y() / north_radius, longitude_rate = p.first.x() / east_radius;
  Kinematics k;
  k.latitude = latitude + p.value.y() / north_radius;
  k.longitude = longitude + p.value.x() / east_radius;
  k.height = height + p.value.z();
  const LocalEarth earth = local_earth(k.latitude, k.height);
  const double s = earth.sin_latitude, c = earth.cos_latitude;
  k.velocity = {earth.transverse_radius * c * longitude_rate, earth.meridian_radius * latitude_rate, p.first.z()};
  // Derivatives of the radii by latitude: d(RN cos L) = -RM sin L, hence dRN = (RN - RM) tan L, and dRM = 3 RM dRN / RN.
  const double rn = earth.transverse_radius - k.height, rm = earth.meridian_radius - k.height, rm_slope = 3 * rm * (rn - rm) / rn * s / c;
  k.acceleration = {(k.velocity.z() * c - k.velocity.y() * s) * longitude_rate + earth.transverse_radius * c * p.second.x() / east_radius,
                    (rm_slope * latitude_rate + k.velocity.z()) * latitude_rate + earth.meridian_radius * p.second.y() / north_radius, p.second.z()};

  const auto q = attitude->at(t);
  const Quaterniond value(q.value), first(q.first);
  k.C_nb = value.normalized().toRotationMatrix();
  k.rate_nb_b = 2 * (value.conjugate() * first).vec() / q.value.squaredNorm();
  return k;
}

}  // namespace

Trajectory track(const Solution& rows, const TrackSmoothing& smoothing) {
  check(rows);
  const auto splines = std::make_shared<const Splines>(rows, smoothing);
  Trajectory out;
  out.breaks = splines->position->knots();
  out.duration = out.breaks.back();
  out.at = [splines](double t) { return splines->at(t); };
  return out;
}

}  // namespace imulab::motion
