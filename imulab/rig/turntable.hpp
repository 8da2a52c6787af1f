// Three-axis turntable: axis angles -> attitude, rate and angular acceleration of the body, and what an IMU on it senses, in closed form.
// At zero angles the body frame is east-north-up; the outer axis points up, the middle axis north, the inner axis east.
#pragma once

#include "imulab/core/rotation.hpp"
#include "imulab/model/compensate.hpp"
#include "imulab/recording/session.hpp"

#include <Eigen/Core>

#include <array>

namespace imulab::rig {

/// Directions of the axes in n at zero angles, by RigAxis; unit vectors, right-handed senses of rotation.
using RigAxes = std::array<Vector3d, 3>;
/// Up, north, east.
RigAxes ideal_axes();

struct AxisState {
  double angle = 0, rate = 0, acceleration = 0;  ///< rad, rad/s, rad/s^2
};
using AxisStates = std::array<AxisState, 3>;  ///< by RigAxis

/// Motion of the body against n, in body axes.
struct BodyState {
  Matrix3d C_nb;
  Vector3d rate_nb_b;                  ///< rad/s
  Vector3d angular_acceleration_nb_b;  ///< rad/s^2
};

/// C_nb = C_nt R(l_outer, outer) R(l_middle, middle) R(l_inner, inner), and its derivatives; C_nt: how the table stands against n.
BodyState turntable_state(const RigAxes& axes, const AxisStates& states, const Matrix3d& C_nt = Matrix3d::Identity());

/// What acts on an IMU at a fixed place besides the rig: Earth rate and gravity, and where its accelerometers sit.
struct Surroundings {
  Vector3d rate_ie_n = Vector3d::Zero();  ///< rad/s
  double gravity = 0;                     ///< m/s^2
  Matrix3d lever_arm = Matrix3d::Zero();  ///< row i: accelerometer i from the axes' intersection, m
};

/// Angular rate against inertial space, and specific force with the size effect of each accelerometer's lever arm.
Motion sensed_motion(const BodyState& body, const Surroundings& surroundings);

}  // namespace imulab::rig

namespace imulab {
using namespace rig;  // until all callers say rig::
}  // namespace imulab
