// The segments of a motion, in the terms of a pilot, a driver or the operator of a table.
#pragma once

#include "imulab/eigen.hpp"
#include "imulab/units.hpp"

#include <vector>

namespace imulab::motion {

/// A smooth pulse of a rate that is zero before and after: it rises over `ramp`, holds, and falls over `ramp`.
struct Pulse {
  /// The integrated quantity: speed [m/s], heading [rad], angle of climb [rad], angle of the table that carries the IMU [rad].
  enum class Of { speed, heading, climb, table } of;
  double begin = 0;                                       // after the start of the segment [s]
  double ramp = 1, hold = 0;                              // s
  double change = 0;                                      // total change of the quantity
  double rate() const { return change / (ramp + hold); }  // between the ramps
  double end() const { return begin + 2 * ramp + hold; }
};

/// Sinusoids of a vibrating base: roll, pitch, heading, and east, north, up, each three a third of a period apart. Their amplitude rises and falls
/// over one second, or over a quarter of the segment if that is less.
struct Sway {
  double angle = 0, angle_frequency = 1;                // amplitude [rad], Hz
  double displacement = 0, displacement_frequency = 1;  // amplitude [m], Hz
};

struct Segment {
  double duration = 0;  // s
  std::vector<Pulse> pulses = {};
  bool rest = false;                                      // at rest except for the sway
  Sway sway = {};                                         // sway of a rest
  Eigen::Vector3d table_axis = Eigen::Vector3d::UnitZ();  // axis of table pulses in body axes

  double change(Pulse::Of of) const;  // change over the whole segment
};

/// Returns a rest.
Segment rest(double duration, const Sway& sway = {});
/// Returns straight motion at the present speed, heading and climb.
Segment straight(double duration);
/// Returns a speed change; a negative one brakes.
Segment accelerate(double speed_change, double duration);
/// Returns a turn to the right (negative: left) at `rate` [rad/s]. An aircraft rolls in and out over `roll_time` [s] each; a vehicle steers. Throws
/// Error if the turn is too short for that.
Segment turn(double heading_change, double rate, double roll_time);
/// Returns speed / radius [rad/s]. Throws Error at zero speed.
double turning_rate(double radius, double speed);
/// Returns a turn to the right by `heading_change` [rad] and back.
Segment s_turn(double heading_change, double rate, double roll_time);
/// Returns a climb at an angle [rad] (negative: a dive), constant for `duration`, and back to level; each change takes `pitch_time` [s].
Segment climb(double angle, double duration, double pitch_time);
/// Returns a permanent change of the angle of climb (positive: up) at `rate` [rad/s].
Segment pitch(double climb_change, double rate, double pitch_time);
/// Returns a permanent rotation of the IMU in its carrier about one of its own axes. It takes up to a second to reach the rate, and to stop.
Segment rotate(const Eigen::Vector3d& body_axis, double angle, double rate);

/// Returns both segments; `second` begins `after` [s] after `first`. Throws Error for a rest, and for rotations of the unit about two axes.
Segment together(const Segment& first, const Segment& second, double after);

/// The carrier of the IMU: an aircraft banks into a turn (tan(bank) = speed x rate / g); a vehicle stays level, with lateral force on its wheels.
struct Carrier {
  bool banks = true;
  double bank_limit = 60 * unit::deg;  // for an aircraft
  double lateral_limit = 4;            // for a vehicle: lateral acceleration [m/s^2]
};

/// Throws Error if a segment at this speed is impossible: a turn too tight for the speed, a rest in motion, or braking beyond standstill.
void check_segment(const Segment& segment, double speed, const Carrier& carrier);

/// A quantity with two time derivatives.
struct Derivatives {
  double value = 0, first = 0, second = 0;
};

/// Returns the change of a quantity by a segment's pulses until `t` [s] after its start.
Derivatives pulses_at(const Segment& segment, Pulse::Of of, double t);
/// Returns a vibration's `phase` (0 to 2 thirds of a period) at `t` [s] after the start of the segment.
Derivatives sway_at(double amplitude, double frequency, int phase, double duration, double t);
/// Returns the rise time of the vibration's amplitude.
double sway_ramp(double duration);

}  // namespace imulab::motion
