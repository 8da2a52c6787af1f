#include "imulab/navigation/motion/segment.hpp"

#include "imulab/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace imulab::motion {
namespace {

constexpr double shortest = 1e-6;    // s
constexpr double standstill = 1e-9;  // m/s: remainder of sums of speed changes

/// A smooth step from 0 to 1 over x = 0 to 1 with two zero derivatives at both ends; its integral and derivatives.
double step_value(double x) { return x * x * x * (10 - x * (15 - 6 * x)); }
double step_integral(double x) { return x * x * x * x * (2.5 - x * (3 - x)); }
double step_slope(double x) { return 30 * x * x * (1 - x) * (1 - x); }
double step_curvature(double x) { return 60 * x * (1 - x) * (1 - 2 * x); }

/// Returns the integral of a pulse until `t` after the start of its segment.
Derivatives pulse_at(const Pulse& p, double t) {
  const double s = t - p.begin, rate = p.rate(), out = p.ramp + p.hold;
  if (s <= 0) return {};
  if (s >= out + p.ramp) return {p.change, 0, 0};
  if (s < p.ramp) return {rate * p.ramp * step_integral(s / p.ramp), rate * step_value(s / p.ramp), rate / p.ramp * step_slope(s / p.ramp)};
  if (s <= out) return {rate * (s - p.ramp / 2), rate, 0};
  const double x = 1 - (s - out) / p.ramp;  // the fall mirrors the rise
  return {p.change - rate * p.ramp * step_integral(x), rate * step_value(x), -rate / p.ramp * step_slope(x)};
}

Segment turned(Pulse::Of of, double change, double rate, double roll_time) {
  const char* const what = of == Pulse::Of::climb ? "pitch" : "turn";
  const char* const ramp = of == Pulse::Of::climb ? "pitch" : "roll";
  if (!(rate > 0 && roll_time > 0)) throw Error(fmt::format("{}: expected a positive rate and a positive time to {} in", what, ramp));
  const double hold = std::abs(change) / rate - roll_time;
  if (hold < 0)
    throw Error(fmt::format("{} by {:.3f} deg at {:.3f} deg/s: expected at least {:.3f} s, the time to {} in", what, change / unit::deg,
                            rate / unit::deg, roll_time, ramp));
  return {hold + 2 * roll_time, {{of, 0, roll_time, hold, change}}};
}

/// Throws Error for a turn tighter than the speed allows.
void check_turn(double rate, double speed, const Carrier& carrier) {
  const double lateral = speed * std::abs(rate);  // m/s^2
  const double most = carrier.banks ? unit::g * std::tan(carrier.bank_limit) : carrier.lateral_limit;
  if (lateral <= most * (1 + 1e-9)) return;
  const std::string needed = carrier.banks ? fmt::format("a bank of {:.1f} deg", std::atan(lateral / unit::g) / unit::deg)
                                           : fmt::format("{:.2f} m/s^2 across its path", lateral);
  const std::string limit = carrier.banks ? fmt::format("{:g} deg", carrier.bank_limit / unit::deg) : fmt::format("{:g} m/s^2", most);
  throw Error(
      fmt::format("turn of {:.3f} deg/s at {:.2f} m/s: needs {}, expected at most {}; the tightest turn at this speed is {:.3f} deg/s, "
                  "a radius of {:.1f} m",
                  std::abs(rate) / unit::deg, speed, needed, limit, most / speed / unit::deg, speed * speed / most));
}

}  // namespace

double Segment::change(Pulse::Of of) const {
  double sum = 0;
  for (const Pulse& p : pulses) sum += p.of == of ? p.change : 0;
  return sum;
}

Segment rest(double duration, const Sway& sway) {
  Segment s{.duration = duration};
  s.rest = true;
  s.sway = sway;
  return s;
}

Segment straight(double duration) { return {.duration = duration}; }

Segment accelerate(double speed_change, double duration) { return {duration, {{Pulse::Of::speed, 0, duration / 4, duration / 2, speed_change}}}; }

Segment turn(double heading_change, double rate, double roll_time) { return turned(Pulse::Of::heading, heading_change, rate, roll_time); }

double turning_rate(double radius, double speed) {
  if (!(radius > 0)) throw Error(fmt::format("turn of radius {} m: expected a positive radius", radius));
  if (!(speed > standstill)) throw Error(fmt::format("turn of radius {} m at no speed: expected one in motion, or a rotation of the IMU", radius));
  return speed / radius;
}

Segment s_turn(double heading_change, double rate, double roll_time) {
  Segment s = turned(Pulse::Of::heading, heading_change, rate, roll_time);
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

Segment pitch(double climb_change, double rate, double pitch_time) { return turned(Pulse::Of::climb, climb_change, rate, pitch_time); }

Segment rotate(const Eigen::Vector3d& body_axis, double angle, double rate) {
  if (!(rate > 0) || !(std::abs(angle) > 0) || !(std::abs(body_axis.norm() - 1) < 1e-9))
    throw Error("rotation: expected an axis of length one, an angle and a positive rate");
  const double time = std::abs(angle) / rate, ramp = std::min(1., time);
  Segment s{time + ramp, {{Pulse::Of::table, 0, ramp, time - ramp, angle}}};
  s.table_axis = body_axis;
  return s;
}

Segment together(const Segment& first, const Segment& second, double after) {
  if (first.rest || second.rest) throw Error("a rest cannot overlap another segment");
  if (!(after >= 0)) throw Error(fmt::format("together after {:g} s: expected 0 or more", after));
  const auto turns = [](const Segment& s) {
    return std::any_of(s.pulses.begin(), s.pulses.end(), [](const Pulse& p) { return p.of == Pulse::Of::table; });
  };
  if (turns(first) && turns(second) && first.table_axis != second.table_axis)
    throw Error("rotations of the IMU at the same time: expected one axis for all");
  Segment both = first;
  both.duration = std::max(first.duration, after + second.duration);
  if (turns(second)) both.table_axis = second.table_axis;
  for (Pulse p : second.pulses) {
    p.begin += after;
    both.pulses.push_back(p);
  }
  return both;
}

void check_segment(const Segment& segment, double speed, const Carrier& carrier) {
  if (!(segment.duration >= shortest && std::isfinite(segment.duration)))
    throw Error(fmt::format("lasts {:g} s, expected a microsecond at least", segment.duration));
  const double end = speed + segment.change(Pulse::Of::speed);
  if (!(end > -standstill)) throw Error(fmt::format("the speed would end at {:.3f} m/s, expected 0 or more", end));
  if (segment.rest && speed > standstill) throw Error(fmt::format("rest at {:.3f} m/s: expected standstill; brake before it", speed));
  for (const Pulse& p : segment.pulses) {
    if (!(p.begin >= 0 && p.ramp >= shortest && p.hold >= 0 && p.end() <= segment.duration * (1 + 1e-9)))
      throw Error("a change of motion: expected inside its segment, with ramps of a microsecond at least");
    if (p.of == Pulse::Of::climb && !(std::max(speed, end) > standstill)) throw Error("climb at no speed: expected one in motion");
    if (p.of != Pulse::Of::heading) continue;
    for (const double t : {p.begin + p.ramp, p.begin + p.ramp + p.hold})
      check_turn(p.rate(), speed + pulses_at(segment, Pulse::Of::speed, t).value, carrier);
  }
}

Derivatives pulses_at(const Segment& segment, Pulse::Of of, double t) {
  Derivatives sum;
  for (const Pulse& p : segment.pulses) {
    if (p.of != of) continue;
    const Derivatives add = pulse_at(p, t);
    sum = {sum.value + add.value, sum.first + add.first, sum.second + add.second};
  }
  return sum;
}

double sway_ramp(double duration) { return std::min(1., duration / 4); }

Derivatives sway_at(double amplitude, double frequency, int phase, double duration, double t) {
  if (amplitude == 0) return {};
  const double ramp = sway_ramp(duration), edge = std::min(t, duration - t) / ramp, sign = t < duration - t ? 1 : -1;
  const double x = std::clamp(edge, 0., 1.), w = 2 * std::numbers::pi * frequency, a = w * t + 2 * std::numbers::pi / 3 * phase;
  const Derivatives e{step_value(x), sign * step_slope(x) / ramp, step_curvature(x) / ramp / ramp};  // the envelope
  const Derivatives s{amplitude * std::sin(a), amplitude * w * std::cos(a), -amplitude * w * w * std::sin(a)};
  return {e.value * s.value, e.first * s.value + e.value * s.first, e.second * s.value + 2 * e.first * s.first + e.value * s.second};
}

}  // namespace imulab::motion
