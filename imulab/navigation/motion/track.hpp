// A recorded track as a motion: splines through position and attitude against time.
#pragma once

#include "imulab/navigation/motion/trajectory.hpp"

namespace imulab::motion {

/// Accuracy of the track's rows, one sigma of each axis: the splines are the smoothest whose RMS distance from the rows is that. 0: through the rows.
struct TrackSmoothing {
  double position = 0;  // m
  double attitude = 0;  // rad
};

/// Time begins at the first row; the rows' velocities are not used. Throws Error for fewer than four rows, times that do not ascend, numbers that
/// are not finite, a latitude within 0.1 deg of a pole, and an attitude that turns by 90 deg or more from one row to the next.
Trajectory track(const Solution& rows, const TrackSmoothing& smoothing = {});

}  // namespace imulab::motion
