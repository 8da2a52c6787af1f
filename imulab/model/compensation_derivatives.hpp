// Inputs of a compensated sample: its derivatives, the range of its thermal readings, and lever arms.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/compensate.hpp"
#include "imulab/core/rotation.hpp"
#include "imulab/eigen.hpp"
#include "imulab/sensor_model.hpp"

#include <array>
#include <span>

namespace imulab {

/// Returns true if this thermal reading, in its unit, is in the calibrated range. A range of [0, 0] means none was given and contains every reading.
inline bool in_range(const ThermalReading& calibrated, double reading) {
  const auto [low, high] = calibrated.range;
  return !calibrated.has_range() || (reading >= low && reading <= high);
}

// The size effect: accelerometers away from the body's origin measure the acceleration of their own positions when the body turns.

/// Returns S = [w' x] + w w^T - |w|^2 I: a point at r [m] has the acceleration S r = w' x r + w x (w x r) [m/s^2] relative to the origin. `rate` is w
/// [rad/s] relative to inertial space, `angular_acceleration` its derivative [rad/s^2], both in body axes.
inline Matrix3d size_effect(const Vector3d& rate, const Vector3d& angular_acceleration) {
  return skew<double>(angular_acceleration) + rate * rate.transpose() - rate.squaredNorm() * Matrix3d::Identity();
}

/// Returns the specific force due to lever arms [m/s^2]: element i belongs to accelerometer i, at row i of `lever_arm` [m].
inline Vector3d size_effect(const Vector3d& rate, const Vector3d& angular_acceleration, const Matrix3d& lever_arm) {
  return size_effect(rate, angular_acceleration).cwiseProduct(lever_arm).rowwise().sum();
}

// Derivatives of a calibrated sample by coefficients, raw readings and thermal readings. With a covariance of the coefficients, they give the
// uncertainty of the compensated output.

/// Derivatives; the rows of every matrix are rate x y z [rad/s], force x y z [m/s^2].
struct CompensationDerivatives {
  Motion motion;                                             ///< compensate(model, raw)
  Eigen::Matrix<double, 6, coefficient_count> coefficients;  ///< columns by table index; lever arms do not act on a single sample
  Eigen::Matrix<double, 6, 6> raw;                           ///< gyro x y z, accel x y z
  Eigen::Matrix<double, 6, 6> temperature;                   ///< gyro tau x y z, accel tau x y z
};
CompensationDerivatives compensation_derivatives(const SensorModel& model, const RawSample& raw);

}  // namespace imulab
