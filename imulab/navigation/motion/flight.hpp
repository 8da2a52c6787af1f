// Motions composed of segments: of an aircraft, a vehicle, or a table.
#pragma once

#include "imulab/navigation/motion/segment.hpp"
#include "imulab/navigation/motion/trajectory.hpp"

#include <vector>

namespace imulab::motion {

struct FlightStart {
  double latitude = 0, longitude = 0, height = 0;  // rad, m
  double speed = 0, heading = 0;                   // m/s, rad
  double climb = 0;                                // rad: a launcher's elevation; 0: level
};

/// Velocity and attitude are closed forms of time; the position is their integral on the ellipsoid (Runge-Kutta over 0.1 s at most, micrometers).
/// Throws Error with the segment's number for what `check_segment` refuses, and for a path that comes within 0.1 deg of a pole.
Trajectory flight(const FlightStart& start, const std::vector<Segment>& segments, const Carrier& carrier = {});

}  // namespace imulab::motion
