// The pieces of a motion, as a pilot, a driver or the operator of a table would name them.
#pragma once

#include "imulab/core/units.hpp"

#include <Eigen/Core>

#include <vector>

namespace imulab {

/// A smooth push on a rate that is zero before and after: it rises over `ramp`, holds, and falls over `ramp`.
struct Pulse {
  /// Acts on the derivative of: speed [m/s], heading [rad], angle of climb [rad], angle of the table that carries the IMU [rad].
  enum class Of { speed, heading, climb, table } of;
  double begin = 0;                                       // after the segment's start [s]
  double ramp = 1, hold = 0;                              // s
  double change = 0;                                      // of the quantity, by the whole pulse
  double rate() const { return change / (ramp + hold); }  // while it holds
  double end() const { return begin + 2 * ramp + hold; }
};

/// Sinusoids of a vibrating base: roll, pitch, heading, and east, north, up, each three a third of a period apart. They swell and fade over
/// one second, or a quarter of the segment where that is less.
struct Sway {
  double angle = 0, angle_frequency = 1;                // amplitude [rad], Hz
  double displacement = 0, displacement_frequency = 1;  // amplitude [m], Hz
};

struct Segment {
  double duration = 0;  // s
  std::vector<Pulse> pulses = {};
  bool rest = false;                                      // stands still but for the sway
  Sway sway = {};                                         // of a rest
  Eigen::Vector3d table_axis = Eigen::Vector3d::UnitZ();  // of the pulses of the table, in body axes

  double change(Pulse::Of of) const;  // by the whole segment
};

/// Standing still.
Segment rest(double duration, const Sway& sway = {});
/// Straight on at the speed, heading and climb reached.
Segment straight(double duration);
/// Negative: brakes.
Segment accelerate(double speed_change, double duration);
/// To the right (negative: left) at `rate`. An aircraft rolls in and out over `roll_time` each, a vehicle steers. `Error` where the turn is too
/// short for that.
Segment turn(double heading_change, double rate, double roll_time);
/// Speed over radius. `Error` at no speed.
double turning_rate(double radius, double speed);
/// Right by `heading_change` and back.
Segment s_turn(double heading_change, double rate, double roll_time);
/// To an angle of climb (negative: a dive), held for `duration`, and back to level, each change over `pitch_time`.
Segment climb(double angle, double duration, double pitch_time);
/// Its angle of climb changes (positive: up) at `rate`, and stays so.
Segment pitch(double climb_change, double rate, double pitch_time);
/// The IMU turns against what carries it, about one of its own axes, and stays so. It takes up to a second to reach the rate, and to stop.
Segment rotate(const Eigen::Vector3d& body_axis, double angle, double rate);

/// Both at once: `second` begins `after` seconds after `first`. `Error` for a rest, and for rotations of the unit about two axes.
Segment together(const Segment& first, const Segment& second, double after);

/// What carries the IMU: an aircraft banks into a turn (tan(bank) = speed x rate / g), a vehicle keeps level and is held by its wheels.
struct Carrier {
  bool banks = true;
  double bank_limit = 60 * unit::deg;  // an aircraft's
  double lateral_limit = 4;            // a vehicle's acceleration across its way [m/s^2]
};

/// Throws Error where a segment begun at this speed is none: a turn tighter than the speed allows, a rest in motion, braking beyond standstill.
void check_segment(const Segment& segment, double speed, const Carrier& carrier);

/// A quantity with two derivatives.
struct Course {
  double value = 0, first = 0, second = 0;
};

/// What a segment's pulses have added to a quantity at `t` after its start.
Course pulses_at(const Segment& segment, Pulse::Of of, double t);
/// A vibration's `phase` (0 to 2 thirds of a period) at `t` after the segment's start.
Course sway_at(double amplitude, double frequency, int phase, double duration, double t);
/// How long the vibration swells.
double sway_ramp(double duration);

}  // namespace imulab
