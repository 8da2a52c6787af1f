// Noise as a model, and grades of IMUs: how far an IMU of a grade departs from the ideal before calibration, as one sigma of a draw
// (docs/theory/effects.md).
//
// Example:
//   session.imu.grade = "mems";
//   session.imu.gyro_noise = NoiseModel{.N = 0.003 * unit::deg_per_sqrt_h, .B = 5 * unit::deg_per_h};
//   const double bias = grade("mems").gyro_bias;  // rad/s, one sigma
//
// SI: rad/s or m/s^2 and their multiples. The terms are those of IEEE Std 952. `grade` throws Error that lists the known names. Safe on any thread.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string_view>

namespace imulab {

// A declared size of what a simulation draws.

/// A number that a simulation draws from: one sigma of a draw, or exactly itself.
struct Spread {
  double value = 0;
  bool fixed = false;
  bool operator==(const Spread&) const = default;
};

// Errors of a triad's readings that are not in the sensor model: noise terms with the names of IEEE Std 952, and the limits of its output.

/// SI of the triad's output u: rad/s or m/s^2. The coefficients Q, N, B and K are exact sizes; turn-on bias and rate ramp are constant in a
/// recording and drawn anew for each, by axis (fixed: the same on every axis). Zero: the term is absent.
struct NoiseModel {
  double Q = 0;           ///< quantization [u s]: white noise of the output's integral. Allan deviation sqrt(3) Q / tau
  double N = 0;           ///< angle or velocity random walk [u/sqrt(Hz)]: N / sqrt(tau)
  double B = 0;           ///< bias instability, flicker [u]: 0.664 B at its plateau
  double K = 0;           ///< rate random walk [u/sqrt(s)]: K sqrt(tau / 3)
  Spread R{};             ///< rate ramp [u/s]: R tau / sqrt(2)
  Spread turn_on{};       ///< bias of a turn-on [u]
  double resolution = 0;  ///< of a reading, in the raw unit (an increment's over its interval)
  double range = 0;       ///< largest reading, either way, likewise
  bool operator==(const NoiseModel&) const = default;
};

/// Noise of one axis of each triad, SI; the same for all three axes.
struct NoiseModels {
  NoiseModel gyro, accel;
};

/// A size drawn uniformly between two bounds, with either sign.
using SizeRange = std::array<double, 2>;

/// Errors of an IMU that a linear model at one temperature does not contain, SI.
struct NonlinearRanges {
  SizeRange gyro_misalignment, accel_misalignment;  ///< rad: all six of a triad, in the frame of the case
  SizeRange gyro_quadratic, accel_quadratic;        ///< of the scale, per raw unit
  SizeRange gyro_cubic, accel_cubic;                ///< likewise, squared
  SizeRange g_sensitivity;                          ///< (rad/s)/(m/s^2)
  double gyro_drift, accel_drift;                   ///< rad/s, m/s^2, one sigma: of the linear term at the end of the temperatures, 45 K from 25 degC
  double gyro_curvature, accel_curvature;           ///< likewise of the quadratic term
};

/// One sigma of the terms that an IMU of a grade may have and that are not drawn, SI: a calibration's priors (sources: docs/theory/effects.md).
struct TermSizes {
  double accel_quadratic, accel_cubic;  ///< 1/(m/s^2), 1/(m/s^2)^2
  double gyro_quadratic, gyro_cubic;    ///< 1/(rad/s), 1/(rad/s)^2
  double g_sensitivity;                 ///< (rad/s)/(m/s^2)
};

/// One-sigma spreads, SI; each coefficient of an IMU is drawn independently.
struct Grade {
  std::string_view name;
  double gyro_bias, accel_bias;                  ///< rad/s, m/s^2
  double gyro_scale, accel_scale;                ///< relative
  double gyro_misalignment, accel_misalignment;  ///< rad; gyros: all six; accelerometers: the three non-orthogonalities
  double g_sensitivity;                          ///< (rad/s)/(m/s^2)
  TermSizes terms;
  NoiseModel gyro_noise, accel_noise;       ///< resolution and range in SI: the raw unit of a drawn IMU
  std::optional<NonlinearRanges> ranges{};  ///< drawn from these in place of the misalignments and g-sensitivity above, which are their RMS
};

/// strategic, navigation, tactical, mems, mems-30g.
std::span<const Grade> grades();

/// A grade by its name; throws Error that lists the known ones.
const Grade& grade(std::string_view name);

}  // namespace imulab
