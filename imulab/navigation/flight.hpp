// Motions put together from segments, as a pilot or a driver would name them.
#pragma once

#include "imulab/navigation/trajectory.hpp"

#include <vector>

namespace imulab {

/// A smooth push on a rate that is zero before and after: it rises over `ramp`, holds, and falls over `ramp`.
struct Pulse {
  enum class Of { speed, heading, climb } of;  // acts on the derivative of: speed [m/s], heading [rad], angle of climb [rad]
  double begin = 0;                            // after the segment's start [s]
  double ramp = 1, hold = 0;                   // s
  double change = 0;                           // of the quantity, by the whole pulse
};

struct Segment {
  double duration = 0;  // s
  std::vector<Pulse> pulses = {};
};

/// Rest, or straight on at the speed, heading and climb reached.
Segment straight(double duration);
Segment accelerate(double speed_change, double duration);
/// Coordinated: the bank follows from speed and turning rate, and rolls in and out over `roll_time`. `Error` where that is longer than half the turn.
Segment turn(double heading_change, double rate, double roll_time);
/// Right by `heading_change` and back.
Segment s_turn(double heading_change, double rate, double roll_time);
/// To an angle of climb (negative: a dive), held for `duration`, and back to level, each change over `pitch_time`.
Segment climb(double angle, double duration, double pitch_time);

struct FlightStart {
  double latitude = 0, longitude = 0, height = 0;  // rad, m
  double speed = 0, heading = 0;                   // m/s, rad; level
};

/// Velocity and attitude are closed forms of time; the position is their integral on the ellipsoid (Runge-Kutta over 0.1 s, below a micrometre).
Trajectory flight(const FlightStart& start, const std::vector<Segment>& segments);

}  // namespace imulab
