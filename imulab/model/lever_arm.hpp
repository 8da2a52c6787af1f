// The size effect: accelerometers that are not at the body's origin measure the acceleration of their own places as the body turns.
#pragma once

#include "imulab/core/rotation.hpp"

namespace imulab {

/// S = [w' x] + w w^T - |w|^2 I: a point at r [m] has the acceleration S r = w' x r + w x (w x r) [m/s^2] against the origin. `rate` w [rad/s]
/// against inertial space and its derivative [rad/s^2], all in body axes.
inline Matrix3d size_effect(const Vector3d& rate, const Vector3d& angular_acceleration) {
  return skew<double>(angular_acceleration) + rate * rate.transpose() - rate.squaredNorm() * Matrix3d::Identity();
}

/// What lever arms add to the specific force [m/s^2]: element i is that of the accelerometer on axis i, at row i of `lever_arm` [m].
inline Vector3d size_effect(const Vector3d& rate, const Vector3d& angular_acceleration, const Matrix3d& lever_arm) {
  return size_effect(rate, angular_acceleration).cwiseProduct(lever_arm).rowwise().sum();
}

}  // namespace imulab
