#include "imulab/rig/turntable.hpp"

#include "imulab/model/lever_arm.hpp"

#include <Eigen/Geometry>

namespace imulab::rig {

RigAxes ideal_axes() { return {Vector3d::UnitZ(), Vector3d::UnitY(), Vector3d::UnitX()}; }

BodyState turntable_state(const RigAxes& axes, const AxisStates& states, const Matrix3d& C_nt) {
  const auto& [outer, middle, inner] = states;
  const Matrix3d C_middle = rotation_about(axes[1], middle.angle), C_inner = rotation_about(axes[2], inner.angle);
  // The axes as the body sees them: an axis is fixed in the frame it carries, and turned back by the axes inside it.
  const Vector3d& l_inner = axes[2];
  const Vector3d l_middle = C_inner.transpose() * axes[1];
  const Vector3d l_outer = C_inner.transpose() * (C_middle.transpose() * axes[0]);
  const Vector3d rate_inner = inner.rate * l_inner, rate_middle = middle.rate * l_middle, rate_outer = outer.rate * l_outer;
  // l_middle turns in b with -rate_inner, l_outer with -(rate_middle + rate_inner).
  const Vector3d turning_axes = -rate_inner.cross(rate_middle) - (rate_middle + rate_inner).cross(rate_outer);
  return {C_nt * rotation_about(axes[0], outer.angle) * C_middle * C_inner, rate_outer + rate_middle + rate_inner,
          outer.acceleration * l_outer + middle.acceleration * l_middle + inner.acceleration * l_inner + turning_axes};
}

Motion sensed_motion(const BodyState& body, const Surroundings& surroundings) {
  const Vector3d rate_ie_b = body.C_nb.transpose() * surroundings.rate_ie_n;
  const Vector3d w = body.rate_nb_b + rate_ie_b;                                            // w_ib_b
  const Vector3d w_dot = body.angular_acceleration_nb_b - body.rate_nb_b.cross(rate_ie_b);  // Earth's rate turns in b with -w_nb_b
  return {surroundings.gravity * body.C_nb.row(2).transpose() + size_effect(w, w_dot, surroundings.lever_arm),
          w};  // C_bn (0, 0, g), and the size effect
}

}  // namespace imulab::rig
