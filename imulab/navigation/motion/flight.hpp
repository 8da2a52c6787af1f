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

// A recorded track as a motion: splines through position and attitude against time.

/// Accuracy of the track's rows, one sigma of each axis: the splines are the smoothest whose RMS distance from the rows is that. 0: through the rows.
struct TrackSmoothing {
  double position = 0;  // m
  double attitude = 0;  // rad
};

/// Time begins at the first row; the rows' velocities are not used. Throws Error for fewer than four rows, times that do not ascend, numbers that
/// are not finite, a latitude within 0.1 deg of a pole, and an attitude that turns by 90 deg or more from one row to the next.
Trajectory track(const Solution& rows, const TrackSmoothing& smoothing = {});

}  // namespace imulab::motion
