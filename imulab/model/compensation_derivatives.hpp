// What a compensated sample depends on: its derivatives, the range of its thermal readings, and lever arms.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/compensate.hpp"
#include "imulab/core/rotation.hpp"
#include "imulab/eigen.hpp"
#include "imulab/sensor_model.hpp"

#include <array>
#include <span>
#include <string_view>

namespace imulab {

/// True if this thermal reading, in its unit, is in the calibrated range. A range of [0, 0] was not given: it contains every reading.
inline bool in_range(const ThermalReading& calibrated, double reading) {
  const auto [low, high] = calibrated.range;
  return (low == 0 && high == 0) || (reading >= low && reading <= high);
}

/// The form of the samples that a SampleCompensator takes.
struct SampleOptions {
  std::string_view gyro_unit = "rad/s", accel_unit = "m/s^2";                        ///< of the readings: these, or "count"
  std::string_view gyro_temperature_unit = "degC", accel_temperature_unit = "degC";  ///< or "K", "raw"
  /// Lever arms act over several samples, not on one. false: a model that has some is refused; true: the forces stay those at the accelerometers'
  /// own places, as in all overloads of `compensate` (remove_lever_arms brings those of a recording to the body's origin).
  bool leave_lever_arms = false;
};

/// Compensation for a real-time loop. The model is checked once, when it is made; a call allocates nothing, takes some tens of nanoseconds, and gives
/// what `compensate` and the command give, to the last bit. A reading that is not finite gives a motion that is not.
///
/// Constant after its construction: any number of threads may call one object at the same time without a lock. Copies are independent.
class SampleCompensator {
 public:
  /// Throws Error that lists all of it: a coefficient that is not finite, readings or temperatures in other units than those of the model, thermal
  /// terms without a reference temperature, and lever arms, unless the options leave them.
  explicit SampleCompensator(const SensorModel& model, const SampleOptions& options = {});

  /// Throws Error where the model has thermal terms.
  Motion operator()(const Vector3d& gyro, const Vector3d& accel) const;
  /// With the thermal readings of each axis, as they are read: not less the reference. Those of a triad without thermal terms are not used.
  Motion operator()(const Vector3d& gyro, const Vector3d& accel, const Vector3d& gyro_temperature, const Vector3d& accel_temperature) const {
    return compensate(model_, {gyro, accel, gyro_temperature - gyro_reference_, accel_temperature - accel_reference_});
  }
  /// With one thermal reading for all axes.
  Motion operator()(const Vector3d& gyro, const Vector3d& accel, double temperature) const {
    return (*this)(gyro, accel, Vector3d::Constant(temperature), Vector3d::Constant(temperature));
  }

  bool needs_temperature() const { return needs_temperature_; }

 private:
  SensorModel model_;
  Vector3d gyro_reference_ = Vector3d::Zero(), accel_reference_ = Vector3d::Zero();
  bool needs_temperature_ = false;
};

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
