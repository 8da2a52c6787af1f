// Attitude angles: roll, pitch, heading of the body axes (right, forward, up) against east, north, up.
#pragma once

#include <Eigen/Core>

namespace imulab {

struct EulerAngles {
  double roll = 0;     // right side down [rad]
  double pitch = 0;    // up [rad]
  double heading = 0;  // clockwise from north [rad]
};

/// Body to east-north-up.
Eigen::Matrix3d attitude_matrix(const EulerAngles& angles);

/// The angles of an attitude: roll and heading in (-pi, pi], pitch in [-pi/2, pi/2]. At a pitch of 90 deg roll is zero.
EulerAngles euler_angles(const Eigen::Matrix3d& C_nb);

/// Rate of the body against east-north-up, in body axes (w_nb_b), from the angles and their time derivatives.
Eigen::Vector3d attitude_rate(const EulerAngles& angles, const EulerAngles& derivative);

}  // namespace imulab
