// Priors of the coefficients: one sigma of each term about the declared IMU.
#pragma once

#include "imulab/model/coefficient.hpp"

#include <cmath>

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
inline double prior_sigma(const PriorSizes& sizes, const Coefficient& c, double scale, double thermal_range = 1) {
  const TriadPrior& t = c.triad == Triad::accel ? sizes.accel : sizes.gyro;
  if (c.term == Term::offset) return t.offset;
  if (c.term == Term::matrix) return (c.row == c.column ? t.scale : t.misalignment) * scale;
  if (c.term == Term::quadratic) return t.quadratic * scale * scale;
  if (c.term == Term::cubic) return t.cubic * scale * scale * scale;
  if (c.term == Term::thermal) return t.drift / scale / std::pow(thermal_range, c.column);
  return c.term == Term::g_sensitivity ? sizes.g_sensitivity : sizes.lever_arm;
}

/// The data determine a coefficient if they bring its sigma below this: offsets and scales below a twentieth of the prior (less certain ones are no
/// calibration, and make the equations nonlinear), other terms below half of it.
inline double needed_sigma(const Coefficient& c, double prior) {
  const bool basic = c.term == Term::offset || is_scale(c);
  return (basic ? 0.05 : 0.5) * prior;
}

}  // namespace imulab::kernel
