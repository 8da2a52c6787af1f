// The first guess of what poses leave open: the offset of their clock, how the tracked body lies against the IMU, which way is up in their frame, and
// their scale. The navigation refines all of it from there.
#pragma once

#include "imulab/aid.hpp"
#include "imulab/recording.hpp"

#include <string>

namespace imulab::aided {

struct PoseAlignment {
  double offset = 0;                      ///< s: the stamps are late by it
  Matrix3d body = Matrix3d::Identity();   ///< from the axes of the tracked body to those of the IMU
  Matrix3d frame = Matrix3d::Identity();  ///< from the frame of the poses to level axes
  double scale = 1;                       ///< metres of one unit of the positions
};

/// Aligns poses or attitudes with a recording in SI. Throws Unsupported like common_motion::aligned, and if the quaternions turn the other way.
PoseAlignment align_poses(const Recording& recording, const Aid& aid, const std::string& name);

}  // namespace imulab::aided
