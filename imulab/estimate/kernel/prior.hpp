// Priors of the coefficients: one sigma of each term about the declared IMU. Optional terms are estimated under their prior or considered, even if
// they are not significant, unless the data exclude them.
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

/// Sizes of a triad's terms in calibrated units: u is m/s^2 or rad/s. Zero: the method does not have the term.
struct TriadPrior {
  double offset = 0;        ///< u
  double scale = 0;         ///< relative
  double misalignment = 0;  ///< [rad], of matrix elements off the diagonal
  double quadratic = 0;     ///< 1/u
  double cubic = 0;         ///< 1/u^2
  double drift = 0;         ///< [u], of a thermal term at the end of the range of thermal readings
};

struct PriorSizes {
  TriadPrior accel, gyro;
  double g_sensitivity = 1e-3;  ///< (rad/s)/(m/s^2), 5.6 deg/s/g, a poor MEMS gyro
  double lever_arm = 0;         ///< m
};

/// Returns one sigma of a table coefficient. `scale`: u per raw unit of the input axis; `thermal_range`: range of thermal readings, in their unit.
inline double prior_sigma(const PriorSizes& sizes, const Coefficient& c, double scale, double thermal_range = 1) {
  const TriadPrior& t = c.triad == Triad::accel ? sizes.accel : sizes.gyro;
  if (c.term == Term::offset) return t.offset;
  if (c.term == Term::matrix) return (c.row == c.column ? t.scale : t.misalignment) * scale;
  if (c.term == Term::quadratic) return t.quadratic * scale * scale;
  if (c.term == Term::cubic) return t.cubic * scale * scale * scale;
  if (c.term == Term::thermal) return t.drift / scale / std::pow(thermal_range, c.column);
  if (is_matrix_thermal(c.term)) return 0;  // no method has them as parameters of their own
  return c.term == Term::g_sensitivity ? sizes.g_sensitivity : sizes.lever_arm;
}

/// Returns the sigma below which a coefficient counts as determined: a twentieth of the prior for offsets and scales (less certain ones make the
/// equations nonlinear), half of the prior for other terms.
inline double needed_sigma(const Coefficient& c, double prior) {
  const bool basic = c.term == Term::offset || is_scale(c);
  return (basic ? 0.05 : 0.5) * prior;
}

/// Observed properties of an IMU other than its effects, SI; 0: unknown.
struct SeenOfUnit {
  double accel_noise = 0, gyro_noise = 0;    ///< noise densities at rest
  double accel_offset = 0, gyro_offset = 0;  ///< RMS over the axes
};
/// Combines values of the axes.
SeenOfUnit seen_of_axes(const Vector3d& accel_noise, const Vector3d& gyro_noise, const Vector3d& accel_offset, const Vector3d& gyro_offset);
/// Returns the sigmas of the output axes for independent sigmas of the readings.
Vector3d output_sigma(const Matrix3d& matrix, const Vector3d& raw);

/// A grade with the logarithm of its probability, up to a constant.
struct LikelyGrade {
  std::string name;
  double log_weight = 0;
};
const LikelyGrade& likeliest(const std::vector<LikelyGrade>& grades);
/// Returns the declared grade alone unless the observations contradict it; otherwise every grade with its probability from the observations or, if no
/// grade is declared, from the declared noise.
std::vector<LikelyGrade> likely_grades(const ImuDeclaration& imu, const SeenOfUnit& seen);
/// Returns the IMU with the most probable of these grades.
ImuDeclaration of_likeliest_grade(ImuDeclaration imu, const SeenOfUnit& seen);

/// Returns priors of quadratic, cubic, g-sensitivity and lever arm terms for any method; offsets, scales, misalignments and drifts remain 0. Declared
/// sizes take precedence over those of the grade (docs/theory/effects.md).
PriorSizes optional_priors(const ImuDeclaration& imu);
/// Returns the size to which the prior of an optional term is proportional; null for other terms.
double* size_of(PriorSizes& sizes, const Coefficient& c);
/// Returns true if the term has a declared size of its own.
bool is_declared(const TermSigmas& declared, const Coefficient& c);

/// Returns the IMU with its own effects and optional terms `factor` times as large as expected.
ImuDeclaration of_size(const ImuDeclaration& imu, double factor);

/// Returns the declared turn-on sigma divided by the square root of the number of recordings; absent if none is declared.
std::optional<TurnOn> declared_turn_on(const ImuDeclaration& imu, std::size_t recordings);

}  // namespace imulab::kernel
