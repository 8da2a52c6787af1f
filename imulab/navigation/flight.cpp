#include "imulab/navigation/flight.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

namespace imulab {
namespace {

using Eigen::Vector3d;

/// A quantity with two derivatives.
struct Course {
  double value = 0, first = 0, second = 0;
};

/// Smooth step from 0 to 1 over x = 0 to 1 with two derivatives zero at both ends; its integral and its derivative.
double step_value(double x) { return x * x * x * (10 - x * (15 - 6 * x)); }
double step_integral(double x) { return x * x * x * x * (2.5 - x * (3 - x)); }
double step_slope(double x) { return 30 * x * x * (1 - x) * (1 - x); }

/// What a pulse has added after `t` from its segment's start.
Course pulse_at(const Pulse& p, double t) {
  const double s = t - p.begin, rate = p.change / (p.ramp + p.hold), out = p.ramp + p.hold;
  if (s <= 0) return {};
  if (s >= out + p.ramp) return {p.change, 0, 0};
  if (s < p.ramp) return {rate * p.ramp * step_integral(s / p.ramp), rate * step_value(s / p.ramp), rate / p.ramp * step_slope(s / p.ramp)};
  if (s <= out) return {rate * (s - p.ramp / 2), rate, 0};
  const double x = 1 - (s - out) / p.ramp;  // the fall mirrors the rise
  return {p.change - rate * p.ramp * step_integral(x), rate * step_value(x), -rate / p.ramp * step_slope(x)};
}

struct Controls {
  Course speed, heading, climb;
};

struct Node {  // the start of a segment, or a point inside it
  double time, segment_time;
  std::size_t segment;
  Controls begin;     // at the segment's start
  Vector3d position;  // latitude, longitude, height
};

Controls controls_at(const Controls& begin, const Segment& segment, double t) {
  Controls c{{begin.speed.value}, {begin.heading.value}, {begin.climb.value}};
  for (const Pulse& p : segment.pulses) {
    const Course add = pulse_at(p, t);
    Course& to = p.of == Pulse::Of::speed ? c.speed : p.of == Pulse::Of::heading ? c.heading : c.climb;
    to = {to.value + add.value, to.first + add.first, to.second + add.second};
  }
  return c;
}

Vector3d velocity_of(const Controls& c) {
  const double level = c.speed.value * std::cos(c.climb.value);
  return {level * std::sin(c.heading.value), level * std::cos(c.heading.value), c.speed.value * std::sin(c.climb.value)};
}

Vector3d position_rate(const Vector3d& position, const Vector3d& v) {
  const LocalEarth e = local_earth(position.x(), position.z());
  return {v.y() / e.meridian_radius, v.x() / (e.transverse_radius * e.cos_latitude), v.z()};
}

/// One step of Runge and Kutta's fourth order from a node on.
Vector3d position_after(const Node& n, const Segment& segment, double h) {
  const auto v = [&](double t) { return velocity_of(controls_at(n.begin, segment, n.segment_time + t)); };
  const Vector3d middle = v(h / 2);
  const Vector3d a = position_rate(n.position, v(0)), b = position_rate(n.position + h / 2 * a, middle);
  const Vector3d c = position_rate(n.position + h / 2 * b, middle), d = position_rate(n.position + h * c, v(h));
  return n.position + h / 6 * (a + 2 * b + 2 * c + d);
}

Kinematics kinematics(const Vector3d& position, const Controls& c) {
  Kinematics k;
  k.latitude = position.x();
  k.longitude = position.y();
  k.height = position.z();
  k.velocity = velocity_of(c);
  const double V = c.speed.value, cg = std::cos(c.climb.value), sg = std::sin(c.climb.value);
  const double level_rate = c.speed.first * cg - V * sg * c.climb.first, sh = std::sin(c.heading.value), ch = std::cos(c.heading.value);
  k.acceleration = {level_rate * sh + k.velocity.y() * c.heading.first, level_rate * ch - k.velocity.x() * c.heading.first,
                    c.speed.first * sg + V * cg * c.climb.first};
  // Bank of a coordinated turn: tan(roll) = V heading' cos(climb) / g.
  const double tangent = V * c.heading.first * cg / unit::g, tangent_rate = (level_rate * c.heading.first + V * cg * c.heading.second) / unit::g;
  k.angles = {std::atan(tangent), c.climb.value, c.heading.value};
  k.angle_rates = {tangent_rate / (1 + tangent * tangent), c.climb.first, c.heading.first};
  return k;
}

Segment turned(double change, double rate, double roll_time) {
  if (!(rate > 0 && roll_time > 0)) throw Error("turn: expected a positive rate and a positive time to roll in");
  const double hold = std::abs(change) / rate - roll_time;
  if (hold < 0)
    throw Error(fmt::format("turn by {:.3f} deg at {:.3f} deg/s: expected at least {:.3f} s, the time to roll in", change / unit::deg,
                            rate / unit::deg, roll_time));
  return {hold + 2 * roll_time, {{Pulse::Of::heading, 0, roll_time, hold, change}}};
}

}  // namespace

Segment straight(double duration) { return {duration}; }

Segment accelerate(double speed_change, double duration) { return {duration, {{Pulse::Of::speed, 0, duration / 4, duration / 2, speed_change}}}; }

Segment turn(double heading_change, double rate, double roll_time) { return turned(heading_change, rate, roll_time); }

Segment s_turn(double heading_change, double rate, double roll_time) {
  Segment s = turned(heading_change, rate, roll_time);
  Pulse back = s.pulses.front();
  back.begin = s.duration;
  back.change = -heading_change;
  s.pulses.push_back(back);
  s.duration *= 2;
  return s;
}

Segment climb(double angle, double duration, double pitch_time) {
  const double ramp = pitch_time / 2;
  return {duration + 2 * pitch_time, {{Pulse::Of::climb, 0, ramp, 0, angle}, {Pulse::Of::climb, pitch_time + duration, ramp, 0, -angle}}};
}

Trajectory flight(const FlightStart& start, const std::vector<Segment>& segments) {
  const double node_interval = 0.1;
  const auto nodes = std::make_shared<std::vector<Node>>();
  Node node{0, 0, 0, {{start.speed}, {start.heading}, {}}, {start.latitude, start.longitude, start.height}};
  Trajectory out;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const Segment& s = segments[i];
    if (!(s.duration > 0)) throw Error(fmt::format("segment {}: expected a positive duration", i + 1));
    node.segment = i;
    node.segment_time = 0;
    const double begin = node.time;
    const auto steps = static_cast<std::size_t>(std::ceil(s.duration / node_interval));
    for (std::size_t k = 0; k < steps; ++k) {
      nodes->push_back(node);
      const double next = s.duration * static_cast<double>(k + 1) / static_cast<double>(steps);
      node.position = position_after(node, s, next - node.segment_time);
      node.segment_time = next;
      node.time = begin + next;
    }
    const Controls end = controls_at(node.begin, s, s.duration);
    node.begin = {{end.speed.value}, {end.heading.value}, {end.climb.value}};
    for (const Pulse& p : s.pulses)
      for (double t : {p.begin, p.begin + p.ramp, p.begin + p.ramp + p.hold, p.begin + 2 * p.ramp + p.hold}) out.breaks.push_back(begin + t);
    out.breaks.push_back(node.time);
  }
  out.duration = node.time;
  out.at = [nodes, segments](double t) {
    const auto after = std::upper_bound(nodes->begin() + 1, nodes->end(), t, [](double a, const Node& n) { return a < n.time; });
    const Node& n = *(after - 1);
    const double h = t - n.time;
    return kinematics(position_after(n, segments[n.segment], h), controls_at(n.begin, segments[n.segment], n.segment_time + h));
  };
  if (nodes->empty()) throw Error("a motion: expected at least one segment");
  return out;
}

}  // namespace imulab
