// Poses and attitudes of a tracked body in a frame of their own: motion capture, a robot arm, visual or lidar odometry.
//
// With T the rotation from the frame to level axes, B that from the axes of the tracked body to those of the IMU, s the scale, l the lever arm, and
// all at the time of the measurement, an aid measures
//
//   position y:    s T y = p + C_nb l + d          p: from the session's place, east-north-up
//   attitude q:    T C(q) = D C_nb B               d, D: slow errors of odometry; C(q): from the body to the frame
//
// T = exp(tilt) T0 and B = B0 exp(b) with T0, B0 by pose_alignment.hpp. Only frames with axes to the north know where north is: otherwise the level
// axes are those of the frame, and the Earth's rate in them is three constants.
#pragma once

#include "imulab/navigation/aided/observation.hpp"
#include "imulab/recording.hpp"

#include <optional>

namespace imulab::aided {

ObservedRows observe_pose(const Problem& problem, const Channel& channel, const Observation& observation, const Instant& instant);

/// Aligns the channels with poses or attitudes with the recording, sets the first guess of their states, and moves their observations to the clock of
/// the recording. Throws Error for poses beside a receiver or a heading, which measure in another frame, and Unsupported like align_poses.
void align_channels(Problem& problem, const Recording& recording);

/// Returns the first navigation state by the first pose of a channel, at a place; its velocity by the next poses.
struct PoseStart {
  NavigationState state;
  double time = 0;  // s
};
std::optional<PoseStart> start_by_poses(const Problem& problem, double begin);

}  // namespace imulab::aided
