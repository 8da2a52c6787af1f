// The segments of a motion, as a pilot, a driver or the operator of a table would name them.
#pragma once

#include "imulab/eigen.hpp"
#include "imulab/units.hpp"

#include <vector>

namespace imulab::motion {

/// A smooth pulse of a rate that is zero before and after: it rises over `ramp`, stays, and falls over `ramp`.
struct Pulse {
  /// Whose derivative it is: speed [m/s], heading [rad], angle of climb [rad], angle of the table that carries the IMU [rad].
  enum class Of { speed, heading, climb, table } of;
  double begin = 0;                                       // after the segment's start [s]
  double ramp = 1, hold = 0;                              // s
  double change = 0;                                      // of the quantity, by the whole pulse
  double rate() const { return change / (ramp + hold); }  // between the ramps
  double end() const { return begin + 2 * ramp + hold; }
};

/// Sinusoids of a vibrating base: roll, pitch, heading, and east, north, up, each three a third of a period apart. Their amplitude rises and falls
/// over one second, or a quarter of the segment where that is less.
struct Sway {
  double angle = 0, angle_frequency = 1;                // amplitude [rad], Hz
  double displacement = 0, displacement_frequency = 1;  // amplitude [m], Hz
};

struct Segment {
  double duration = 0;  // s
  std::vector<Pulse> pulses = {};
  bool rest = false;                                      // at rest but for the sway
  Sway sway = {};                                         // of a rest
  Eigen::Vector3d table_axis = Eigen::Vector3d::UnitZ();  // of the pulses of the table, in body axes

  double change(Pulse::Of of) const;  // by the whole segment
};

/// At rest.
Segment rest(double duration, const Sway& sway = {});
/// Straight on at the present speed, heading and climb.
Segment straight(double duration);
/// Negative: brakes.
Segment accelerate(double speed_change, double duration);
/// To the right (negative: left) at `rate` [rad/s]. An aircraft rolls in and out over `roll_time` each, a vehicle steers. Throws Error where the turn
/// is too short for that.
Segment turn(double heading_change, double rate, double roll_time);
/// Speed over radius [rad/s]. Throws Error at no speed.
double turning_rate(double radius, double speed);
/// Right by `heading_change` [rad] and back.
Segment s_turn(double heading_change, double rate, double roll_time);
/// To an angle of climb [rad] (negative: a dive), constant for `duration`, and back to level, each change over `pitch_time` [s].
Segment climb(double angle, double duration, double pitch_time);
/// The angle of climb changes (positive: up) at `rate` [rad/s], and stays so.
Segment pitch(double climb_change, double rate, double pitch_time);
/// The IMU turns against its carrier, about one of its own axes, and stays so. It takes up to a second to reach the rate, and to stop.
Segment rotate(const Eigen::Vector3d& body_axis, double angle, double rate);

/// Both at once: `second` begins `after` [s] after `first`. Throws Error for a rest, and for rotations of the unit about two axes.
Segment together(const Segment& first, const Segment& second, double after);

/// The carrier of the IMU: an aircraft banks into a turn (tan(bank) = speed x rate / g); a vehicle stays level, and its wheels resist the lateral
/// force.
struct Carrier {
  bool banks = true;
  double bank_limit = 60 * unit::deg;  // an aircraft's
  double lateral_limit = 4;            // a vehicle's lateral acceleration [m/s^2]
};

/// Throws Error where a segment that begins at this speed is impossible: a turn tighter than the speed allows, a rest in motion, braking beyond
/// standstill.
void check_segment(const Segment& segment, double speed, const Carrier& carrier);

/// A quantity with two time derivatives.
struct Derivatives {
  double value = 0, first = 0, second = 0;
};

/// The change of a quantity by a segment's pulses until `t` after its start.
Derivatives pulses_at(const Segment& segment, Pulse::Of of, double t);
/// A vibration's `phase` (0 to 2 thirds of a period) at `t` after the segment's start.
Derivatives sway_at(double amplitude, double frequency, int phase, double duration, double t);
/// The time over which the vibration's amplitude rises.
double sway_ramp(double duration);

}  // namespace imulab::motion
