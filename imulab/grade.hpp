// Noise models, and grades of IMUs: how far an IMU of a grade departs from the ideal before calibration, as one sigma of a draw
// (docs/theory/effects.md).
//
// Example:
//   session.imu.grade = "mems";
//   session.imu.gyro_noise = NoiseModel{.N = 0.003 * unit::deg_per_sqrt_h, .B = 5 * unit::deg_per_h};
//   const double bias = grade("mems").gyro_bias;  // rad/s, one sigma
//
// Values are SI: rad/s or m/s^2 and their multiples. Noise terms follow IEEE Std 952. `grade` throws Error with the known names. Safe on any thread.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string_view>

namespace imulab {

// Sizes that a simulation draws.

/// A declared size: the standard deviation of a draw or, if `fixed`, the exact value.
struct Spread {
  double value = 0;
  bool fixed = false;
  bool operator==(const Spread&) const = default;
};

// Errors of a triad's readings that are not in the sensor model: the noise terms of IEEE Std 952, and the limits of the output.

/// Values are SI units of the triad's output u: rad/s or m/s^2. The coefficients Q, N, B and K are exact. Turn-on bias and rate ramp are constant
/// within a recording; each recording draws them for each axis (`fixed`: equal on all axes). A term of zero is absent.
struct NoiseModel {
  double Q = 0;           ///< quantization [u s]: white noise of the output's integral; Allan deviation sqrt(3) Q / tau
  double N = 0;           ///< angle or velocity random walk [u/sqrt(Hz)]; Allan deviation N / sqrt(tau)
  double B = 0;           ///< bias instability, flicker [u]; Allan deviation 0.664 B at its plateau
  double K = 0;           ///< rate random walk [u/sqrt(s)]; Allan deviation K sqrt(tau / 3)
  Spread R{};             ///< rate ramp [u/s]; Allan deviation R tau / sqrt(2)
  Spread turn_on{};       ///< turn-on bias [u]
  double resolution = 0;  ///< resolution of a reading in the raw unit (for an increment: divided by its interval)
  double range = 0;       ///< largest absolute reading, in the same unit
  bool operator==(const NoiseModel&) const = default;
};

/// Noise of each triad, SI, equal for its three axes.
struct NoiseModels {
  NoiseModel gyro, accel;
};

/// The bounds of a size that is drawn uniformly, with random sign.
using SizeRange = std::array<double, 2>;

/// Errors of an IMU beyond a linear model at one temperature, SI.
struct NonlinearRanges {
  SizeRange gyro_misalignment, accel_misalignment;  ///< rad; all six of a triad, in the frame of the case
  SizeRange gyro_quadratic, accel_quadratic;        ///< quadratic term relative to the scale, per raw unit
  SizeRange gyro_cubic, accel_cubic;                ///< cubic term relative to the scale, per raw unit squared
  SizeRange g_sensitivity;                          ///< (rad/s)/(m/s^2)
  double gyro_drift, accel_drift;                   ///< rad/s, m/s^2; one sigma of the linear thermal term at 45 K from 25 degC
  double gyro_curvature, accel_curvature;           ///< likewise, of the quadratic thermal term
};

/// One sigma of terms that an IMU of a grade may have but that are not drawn, SI: priors of a calibration (sources: docs/theory/effects.md).
struct TermSizes {
  double accel_quadratic, accel_cubic;  ///< 1/(m/s^2), 1/(m/s^2)^2
  double gyro_quadratic, gyro_cubic;    ///< 1/(rad/s), 1/(rad/s)^2
  double g_sensitivity;                 ///< (rad/s)/(m/s^2)
};

/// One-sigma spreads, SI. Each coefficient of an IMU is drawn independently.
struct Grade {
  std::string_view name;
  double gyro_bias, accel_bias;                  ///< rad/s, m/s^2
  double gyro_scale, accel_scale;                ///< relative
  double gyro_misalignment, accel_misalignment;  ///< rad; gyros: all six; accelerometers: the three nonorthogonalities
  double g_sensitivity;                          ///< (rad/s)/(m/s^2)
  TermSizes terms;
  NoiseModel gyro_noise, accel_noise;  ///< resolution and range in SI, the raw unit of a simulated IMU
  /// Ranges that replace the misalignments and g-sensitivity above, which are their RMS.
  std::optional<NonlinearRanges> ranges{};
};

/// Returns the grades strategic, navigation, tactical, mems and mems-30g.
std::span<const Grade> grades();

/// Returns the grade with this `name`; throws an Error that lists the known names.
const Grade& grade(std::string_view name);

}  // namespace imulab
