// Priors of the coefficients: one sigma of each term about the declared IMU. An optional term, which an IMU may or may not have, counts whether the
// data show it or not, unless they exclude it: it is estimated under its prior, or considered.
#pragma once

#include "imulab/coefficient.hpp"
#include "imulab/eigen.hpp"
#include "imulab/session.hpp"

#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace imulab::kernel {

/// The sizes of a triad's terms, on the calibrated side: u is m/s^2 or rad/s. Zero: the method has no such term.
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

/// What the data show of an IMU besides its effects, SI; 0: nothing.
struct SeenOfUnit {
  double accel_noise = 0, gyro_noise = 0;    ///< densities at rest
  double accel_offset = 0, gyro_offset = 0;  ///< RMS of the axes
};
/// From those of the axes.
SeenOfUnit seen_of_axes(const Vector3d& accel_noise, const Vector3d& gyro_noise, const Vector3d& accel_offset, const Vector3d& gyro_offset);
/// Sigmas of the output's axes from independent ones of the readings'.
Vector3d output_sigma(const Matrix3d& matrix, const Vector3d& raw);

/// Grades with the logarithms of their probabilities, up to a constant.
struct LikelyGrade {
  std::string name;
  double log_weight = 0;
};
const LikelyGrade& likeliest(const std::vector<LikelyGrade>& grades);
/// The declared grade alone unless what is seen contradicts it; otherwise each, by what is seen or, where no grade is declared, by the declared
/// noise.
std::vector<LikelyGrade> likely_grades(const ImuDeclaration& imu, const SeenOfUnit& seen);
/// With the likeliest of these.
ImuDeclaration of_likeliest_grade(ImuDeclaration imu, const SeenOfUnit& seen);

/// Priors of quadratic, cubic, g-sensitivity and lever arms for any method, in fields of the same name; offsets, scales, misalignments and drifts
/// stay 0. Declared sizes come first, then those of the grade (docs/theory/effects.md).
PriorSizes optional_priors(const ImuDeclaration& imu);
/// The size that the prior of an optional term is proportional to; null for other terms.
double* size_of(PriorSizes& sizes, const Coefficient& c);
/// Is it declared by a key of its own?
bool is_declared(const TermSigmas& declared, const Coefficient& c);

/// The IMU with its own effects and optional terms declared `factor` times as large as expected.
ImuDeclaration of_size(const ImuDeclaration& imu, double factor);

/// The declared sigma of a turn-on over the root of how many were recorded; absent where none is declared.
std::optional<TurnOn> declared_turn_on(const ImuDeclaration& imu, std::size_t recordings);

}  // namespace imulab::kernel
