// The output of inertial sensors for navigation, and effects within a sampling interval: coning and sculling.
//
//   rotation = th + K th_i x th_j,   velocity = dv + (1 - cos t)/t^2 (th x dv) + (1 - sin t/t)/t^2 th x (th x dv) + K (th_i x dv_j + dv_i x th_j)
//
// th, dv: sums of the samples' increments, t = |th|; K depends on the number of samples. Savage 1998, doi:10.2514/2.4228 and 10.2514/2.4242; weights
// of Ignagni 1996, doi:10.2514/3.21635. Valid for angles well below a radian within one interval.
#pragma once

#include "imulab/eigen.hpp"
#include "imulab/navigate.hpp"

#include <span>

namespace imulab::integration {

/// The motion of a body over an interval: the rotation vector [rad] from start to end, and the velocity [m/s] due to the specific force, in the body
/// axes of the start.
struct BodyStep {
  Eigen::Vector3d rotation, velocity;
};

/// Computes a step from one sample and the previous one of equal length (Savage 1998): exact for rates and forces that are linear in time, to third
/// order in the angle.
BodyStep body_step(const Increment& sample, const Increment& previous);

/// Computes a step from one to five samples of equal length (one: without coning and sculling; Ignagni 1996). Throws Error for another number.
BodyStep body_step(std::span<const Increment> samples);

}  // namespace imulab::integration
