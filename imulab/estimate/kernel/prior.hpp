// Priors of the coefficients: one sigma of each term about the declared IMU.
#pragma once

#include "imulab/model/coefficient.hpp"

namespace imulab::kernel {

/// Of a triad, on the calibrated side: u is m/s^2 or rad/s. Zero: the method has no such term.
struct TriadPrior {
  double offset = 0;        ///< u
  double scale = 0;         ///< relative
  double misalignment = 0;  ///< rad: matrix elements off the diagonal
  double quadratic = 0;     ///< 1/u
  double cubic = 0;         ///< 1/u^2
  double drift = 0;         ///< u: of a thermal term at the end of the readings' range
};

struct PriorSizes {
  TriadPrior accel, gyro;
  double g_sensitivity = 1e-3;  ///< (rad/s)/(m/s^2), 5.6 deg/s/g: a poor MEMS gyro
  double lever_arm = 0;         ///< m
};

/// One sigma of a table coefficient. `scale`: u per raw unit of the input axis; `thermal_range`: of the thermal readings, in their unit.
double prior_sigma(const PriorSizes& sizes, const Coefficient& coefficient, double scale, double thermal_range = 1);

/// The data determine a coefficient if they bring its sigma below this: offsets and scales below a twentieth of the prior (less certain ones are no
/// calibration, and make the equations nonlinear), other terms below half of it.
double needed_sigma(const Coefficient& coefficient, double prior);

}  // namespace imulab::kernel
