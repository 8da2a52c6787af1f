// What a compensated sample depends on: its derivatives, the range of its thermal readings, and lever arms.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/compensate.hpp"
#include "imulab/core/rotation.hpp"
#include "imulab/eigen.hpp"
#include "imulab/sensor_model.hpp"

#include <array>
#include <span>

namespace imulab {

/// True if this thermal reading, in its unit, is in the calibrated range. A range of [0, 0] was not given: it contains every reading.
inline bool in_range(const ThermalReading& calibrated, double reading) {
  const auto [low, high] = calibrated.range;
  return (low == 0 && high == 0) || (reading >= low && reading <= high);
}

// The size effect: accelerometers that are not at the body's origin measure the acceleration of their own places as the body turns.

/// S = [w' x] + w w^T - |w|^2 I: a point at r [m] has the acceleration S r = w' x r + w x (w x r) [m/s^2] against the origin. `rate` w [rad/s]
/// against inertial space and its derivative [rad/s^2], all in body axes.
inline Matrix3d size_effect(const Vector3d& rate, const Vector3d& angular_acceleration) {
  return skew<double>(angular_acceleration) + rate * rate.transpose() - rate.squaredNorm() * Matrix3d::Identity();
}

/// Specific force from lever arms [m/s^2]: element i is that of the accelerometer on axis i, at row i of `lever_arm` [m].
inline Vector3d size_effect(const Vector3d& rate, const Vector3d& angular_acceleration, const Matrix3d& lever_arm) {
  return size_effect(rate, angular_acceleration).cwiseProduct(lever_arm).rowwise().sum();
}

// Derivatives of a calibrated sample by the coefficients, the raw readings and the thermal readings. With a covariance of the coefficients they give
// the uncertainty of the compensated output.

/// Rows of every matrix: rate x y z [rad/s], force x y z [m/s^2].
struct CompensationDerivatives {
  Motion motion;                                             ///< compensate(model, raw)
  Eigen::Matrix<double, 6, coefficient_count> coefficients;  ///< by table index; lever arms do not act on a sample alone
  Eigen::Matrix<double, 6, 6> raw;                           ///< gyro x y z, accel x y z
  Eigen::Matrix<double, 6, 6> temperature;                   ///< gyro tau x y z, accel tau x y z
};
CompensationDerivatives compensation_derivatives(const SensorModel& model, const RawSample& raw);

}  // namespace imulab
