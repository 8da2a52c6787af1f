// Motions of an aircraft, a vehicle or a table, composed of segments.
#pragma once

#include "imulab/navigation/motion/segment.hpp"
#include "imulab/navigation/motion/trajectory.hpp"

#include <vector>

namespace imulab::motion {

struct FlightStart {
  double latitude = 0, longitude = 0, height = 0;  // rad, m
  double speed = 0, heading = 0;                   // m/s, rad
  double climb = 0;                                // rad: elevation of a launcher; 0: level
};

/// Returns a motion. Velocity and attitude are closed forms of time; the position is their integral on the ellipsoid (Runge-Kutta over at most 0.1 s,
/// micrometers). Throws Error with the segment number if `check_segment` refuses it, or the path comes within 0.1 deg of a pole.
Trajectory flight(const FlightStart& start, const std::vector<Segment>& segments, const Carrier& carrier = {});

// A recorded track as a motion, by splines of position and attitude over time.

/// Accuracy of a track's rows, one sigma per axis: the splines are the smoothest with this RMS distance from the rows; 0: through the rows.
struct TrackSmoothing {
  double position = 0;  // m
  double attitude = 0;  // rad
};

/// Returns a motion that starts at the first row; velocities of the rows are not used. Throws Error for fewer than four rows, times that do not
/// ascend, numbers that are not finite, a latitude within 0.1 deg of a pole, and an attitude that turns by 90 deg or more between rows.
Trajectory track(const Solution& rows, const TrackSmoothing& smoothing = {});

}  // namespace imulab::motion
