// Compensation raw -> calibrated by the sensor model (Dai 2011 eqs 1-4, doi:10.3788/OPE.20111907.1620), its inverse and its derivatives.
//
//   const Motion motion = compensate(calibration.model, {.accel = {0.1, 0.2, 9.7}, .gyro = {0, 0, 0.01}});
//   motion.force                                                  // m/s^2, in body axes
//
// Valid within the ranges of readings and temperatures that the calibration covered. The inverse converges where the polynomial is monotone.
#pragma once

#include "imulab/core/eigen.hpp"
#include "imulab/core/rotation.hpp"
#include "imulab/model/calibration.hpp"
#include "imulab/model/sensor_model.hpp"

#include <array>
#include <span>

namespace imulab {

/// Specific force and angular rate of one sample [m/s^2, rad/s].
struct Motion {
  Vector3d force, rate;
};

/// Raw readings of one sample, and the thermal readings less their reference (tau), per axis; zero where there are none.
struct RawSample {
  Vector3d accel, gyro;
  Vector3d accel_tau = Vector3d::Zero(), gyro_tau = Vector3d::Zero();
};

/// True if this thermal reading, in its unit, is in the calibrated range. A range of [0, 0] was not given: it contains every reading.
inline bool in_range(const ThermalReading& calibrated, double reading) {
  const auto [low, high] = calibrated.range;
  return (low == 0 && high == 0) || (reading >= low && reading <= high);
}

/// Dai 2011 eqs 1-4.
Motion compensate(const SensorModel& model, const RawSample& raw);

/// The raw readings that compensate to `motion`: Newton from the linear solution. Throws Error where the polynomial cannot be inverted there.
RawSample decompensate(const SensorModel& model, const Motion& motion, const Vector3d& accel_tau = Vector3d::Zero(),
                       const Vector3d& gyro_tau = Vector3d::Zero());

/// A block of samples as columns: six readings, and up to six thermal readings (not less the reference; empty where there are none).
struct RawColumns {
  std::array<std::span<const double>, 3> gyro, accel, gyro_temperature, accel_temperature;
};
struct MotionColumns {
  std::array<std::span<double>, 3> rate, force;
};

/// compensate on columns; `out` may be the input's own memory.
void compensate(const SensorModel& model, const RawColumns& raw, const MotionColumns& out);

/// decompensate on columns, in place: motion becomes raw readings. Thermal readings (not less the reference) may be empty where the model has no
/// thermal terms.
void decompensate(const SensorModel& model, const std::array<std::span<const double>, 3>& accel_temperature,
                  const std::array<std::span<const double>, 3>& gyro_temperature, const MotionColumns& columns);

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

/// Rows of every matrix: force x y z [m/s^2], rate x y z [rad/s].
struct CompensationDerivatives {
  Motion motion;                                             ///< compensate(model, raw)
  Eigen::Matrix<double, 6, coefficient_count> coefficients;  ///< by table index; lever arms do not act on a sample alone
  Eigen::Matrix<double, 6, 6> raw;                           ///< accel x y z, gyro x y z
  Eigen::Matrix<double, 6, 6> temperature;                   ///< accel tau x y z, gyro tau x y z
};
CompensationDerivatives compensation_derivatives(const SensorModel& model, const RawSample& raw);

/// Covariance of a compensated sample from that of the estimated coefficients alone (not from the sample's own noise).
Eigen::Matrix<double, 6, 6> output_covariance(const Calibration& calibration, const RawSample& raw);

}  // namespace imulab
