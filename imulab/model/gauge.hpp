// Several models represent one reading: a shift of the raw reading changes offset, matrix and quadratic terms, and so does a change of the reference
// temperature, at which the thermal drift is zero by definition (c0 = d0 = 0 at T0). Comparisons first convert to one reference.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/eigen.hpp"

#include <functional>
#include <vector>

namespace imulab {

/// A change of an IMU's description: to other readings, or about another point.
using ModelChange = std::function<SensorModel(const SensorModel&)>;

/// Returns the covariance of the table coefficients `indices` (in SI and raw units) after a change that is linear in them, such as another zero or
/// scale of the readings. `covariance` is the one before.
Eigen::MatrixXd covariance_after(const ModelChange& linear_change, const std::vector<CoefficientIndex>& indices, const Eigen::MatrixXd& covariance);

/// Returns Q with Q(V + shift) = P(V) for the polynomial P of `model`; linear in the coefficients.
TriadModel of_shifted_readings(TriadModel model, const Vector3d& shift);
SensorModel of_shifted_readings(SensorModel model, const Vector3d& accel_shift, const Vector3d& gyro_shift);

/// Returns the model with `factor` times the output at the reference temperature. Products of its elements beside the diagonal with nonlinear terms,
/// which are small, are left out.
TriadModel with_factor(TriadModel model, const Matrix3d& factor);

/// Returns an equivalent model with other reference temperatures, in units of the thermal readings, unchanged for a triad without any.
SensorModel with_references(const SensorModel& model, double accel_reference, double gyro_reference);
/// Converts a calibration likewise, with its covariance.
Calibration with_references(const Calibration& calibration, double accel_reference, double gyro_reference);

/// Returns `b` at the reference temperatures of `a`. Throws Error if thermal terms belong to readings in different units.
Calibration in_gauge_of(const Calibration& a, const Calibration& b);

}  // namespace imulab
