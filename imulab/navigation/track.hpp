// A recorded track as a motion: splines through position and attitude against time.
#pragma once

#include "imulab/navigation/trajectory.hpp"

namespace imulab {

/// How far the track's rows are off, one sigma of each axis: the splines are then the smoothest that are as far from them (RMS). 0: through them.
struct TrackSmoothing {
  double position = 0;  // m
  double attitude = 0;  // rad
};

/// Time begins at the first row; the rows' velocities are not used. Throws Error for fewer than four rows, times that do not ascend, numbers that
/// are not finite, a latitude within 0.1 deg of a pole, and an attitude that turns by 90 deg or more from one row to the next.
Trajectory track(const Solution& rows, const TrackSmoothing& smoothing = {});

}  // namespace imulab
