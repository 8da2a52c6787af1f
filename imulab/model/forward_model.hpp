// The sensor model in the forward direction, in which it is linear in its coefficients:  Ua = Da + Fa f,  Ug = Dg + Fg w - E f. Then A1 = Fa^-1, A0 =
// -A1 Da, W1 = Fg^-1, W0 = -W1 Dg, C = W1 E. Nonlinearity is small: to first order, Ua changes by -Fa (A2 n^2 + A3 n^3) with n = Fa f, the reading
// relative to its zero Da; Ug likewise. A2 and A3 refer to this zero here, in the sensor model to a reading of 0.
#pragma once

#include "imulab/coefficient.hpp"
#include "imulab/eigen.hpp"
#include "imulab/sensor_model.hpp"

#include <vector>

namespace imulab {

/// Columns of the forward model; matrices row by row. `turning_bias`: difference of the gyro bias in turns from that at rest. From `nonlinearity` on:
/// A2, A3, W2, W3.
struct Forward {
  static constexpr Eigen::Index accel_offset = 0, accel_matrix = 3, gyro_offset = 12, gyro_matrix = 15, gyro_force = 24, turning_bias = 33,
                                nonlinearity = 36, accel_quadratic = 36, accel_cubic = 39, gyro_quadratic = 42, gyro_cubic = 45, all = 48;
  /// Returns the column that mainly determines a coefficient (not a thermal one or a lever arm).
  static Eigen::Index of(const Coefficient& coefficient);
};

Eigen::VectorXd forward(const SensorModel& model);
SensorModel backward(const Eigen::VectorXd& columns);

/// Returns d coefficient / d column at the model `at`, one row for each of `coefficients` (table indices).
Eigen::MatrixXd backward_derivatives(const SensorModel& at, const std::vector<CoefficientIndex>& coefficients);
/// Returns d^2 coefficient / d column^2, one matrix per coefficient; `scale`: sizes of the columns.
std::vector<Eigen::MatrixXd> backward_curvatures(const SensorModel& at, const std::vector<CoefficientIndex>& coefficients,
                                                 const Eigen::VectorXd& scale);

// A sensor model with an output error that is itself a model.

/// Returns the model whose output is that of `model` minus df = ba + Ma f + q f^2, dw = bg + Mg w + C f of `error`, to first order: A0 <- (I - Ma) A0
/// - ba, A1 <- (I - Ma) A1, gyros likewise. The error of a lever arm is added. Cubic and thermal terms of `error` are ignored.
SensorModel without_error(const SensorModel& model, const SensorModel& error);

}  // namespace imulab
