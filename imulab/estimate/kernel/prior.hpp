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

/// Priors of quadratic, cubic, g-sensitivity and lever arms for any method, in fields of the same name; offsets, scales, misalignments and drifts
/// stay 0. Declared sizes come first, then those of the declared grade, then sizes that grow with the offsets, `accel_offset` [m/s^2] and
/// `gyro_offset` [rad/s]: a sensor whose zero is far off is not straight either (docs/theory/effects.md).
PriorSizes optional_priors(const ImuDeclaration& imu, const Vector3d& accel_offset, const Vector3d& gyro_offset);

/// The declared sigma of a turn-on over the root of how many were recorded; absent where none is declared.
std::optional<TurnOn> declared_turn_on(const ImuDeclaration& imu, std::size_t recordings);

/// By how much a prior about zero is to be widened that the data contradict: estimates under it, with their covariance, are as large as chance makes
/// them less than once in a thousand. Twice their size over what is expected of it, so that the prior pulls neither them nor others. Else 1.
double widening(const Eigen::VectorXd& value, const Eigen::VectorXd& prior_sigma, const Eigen::MatrixXd& covariance);

/// The logarithm of the ratio of the data's probabilities under a prior about zero that is wider by `factor`, and under the present one with which
/// the estimates were made.
double evidence_of_wider(const Eigen::VectorXd& value, const Eigen::VectorXd& prior_sigma, const Eigen::MatrixXd& covariance, double factor);

/// Widens that of an optional term.
void widen_prior(PriorSizes& sizes, const Coefficient& c, double factor);

/// Widens those of `sizes` that these estimates contradict, term by term; their names. Other coefficients among `indices` do not count.
std::vector<std::string> widen_priors(PriorSizes& sizes, const std::vector<CoefficientIndex>& indices, const Eigen::VectorXd& value,
                                      const Eigen::VectorXd& prior_sigma, const Eigen::MatrixXd& covariance);

}  // namespace imulab::kernel
