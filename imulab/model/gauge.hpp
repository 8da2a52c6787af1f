// One reading has several models: a shift of the raw reading changes offset, matrix and quadratic terms, and so does a change of the reference
// temperature, at which the thermal drift is zero by definition (c0 = d0 = 0 at T0). Before calibrations are compared they are brought to one
// reference.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/eigen.hpp"

#include <functional>
#include <vector>

namespace imulab {

/// A change of an IMU's description: to other readings, or about another point.
using ModelChange = std::function<SensorModel(const SensorModel&)>;

/// Covariance of the table coefficients `indices` (in SI and raw units) after a change that is linear in them, such as another zero or scale of the
/// readings. `covariance` is that before.
Eigen::MatrixXd covariance_after(const ModelChange& linear_change, const std::vector<CoefficientIndex>& indices, const Eigen::MatrixXd& covariance);

/// Q with Q(V + shift) = P(V) for the polynomial P of `model`; linear in the coefficients.
TriadModel of_shifted_readings(TriadModel model, const Vector3d& shift);
SensorModel of_shifted_readings(SensorModel model, const Vector3d& accel_shift, const Vector3d& gyro_shift);

/// An equivalent model with other reference temperatures, in the units of the thermal readings. A triad without a reading stays as it is.
SensorModel with_references(const SensorModel& model, double accel_reference, double gyro_reference);
/// With its covariance.
Calibration with_references(const Calibration& calibration, double accel_reference, double gyro_reference);

/// `b` at the reference temperatures of `a`. Throws Error where thermal terms belong to readings in different units.
Calibration in_gauge_of(const Calibration& a, const Calibration& b);

}  // namespace imulab
