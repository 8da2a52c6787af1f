// The sensor model as most programs write it, with biases subtracted from the readings and a forward matrix beside its inverse.
//
//   a = C_a (a_m - b_a - d_a(T)),   w = C_g (w_m - b_g - d_g(T) - G a)        C = T^-1
//   a_m = T_a a + b_a + d_a(T),     w_m = T_g w + G a + b_g + d_g(T)
//
// From imulab's own (model/sensor_model.hpp): C_a = A1, b_a = -A1^-1 A0; C_g = W1, b_g = -W1^-1 W0, G = -W1^-1 C. Quadratic and cubic terms have no
// place in it.
#pragma once

#include "imulab/calibration.hpp"

namespace imulab::export_io {

struct ConsumerTriad {
  Matrix3d C, T;  ///< correction and its inverse
  Vector3d b;     ///< bias at the reference temperature, unit of the readings
};

struct ConsumerModel {
  ConsumerTriad accel, gyro;
  Matrix3d G;  ///< g-sensitivity, (rad/s)/(m/s^2)
};

/// Throws Error where the matrices cannot be inverted or numbers are not finite.
ConsumerModel consumer_model(const SensorModel& model);

/// imulab's model of it: the inverse function.
SensorModel sensor_model(const Matrix3d& C_a, const Vector3d& b_a, const Matrix3d& C_g, const Vector3d& b_g, const Matrix3d& G);

/// Throws Error where the readings are counts: programs that take files of this kind expect m/s^2 and rad/s.
void expect_si_readings(const SensorModel& model);

/// T = L Q: L lower (or upper) triangular with a positive diagonal, Q orthogonal; a rotation where det T > 0.
struct TriangularFactors {
  Matrix3d triangle, Q;
};
TriangularFactors lower_factors(const Matrix3d& T);
TriangularFactors upper_factors(const Matrix3d& T);

/// Throws Error for axes that form a left-handed triad, which no rotation takes to a right-handed one.
void expect_right_handed(const ConsumerModel& model);

}  // namespace imulab::export_io
