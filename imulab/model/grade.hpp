// Grades of IMUs: how far an IMU of a grade departs from the ideal before calibration, as one sigma of a draw.
#pragma once

#include "imulab/model/imu_noise.hpp"

#include <array>
#include <optional>
#include <span>
#include <string_view>

namespace imulab {

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

/// The temperature at which a drawn IMU's thermal terms are zero, and its temperature range, degC.
inline constexpr double drawn_reference = 25;
inline constexpr std::array<double, 2> drawn_temperatures{0, 70};

/// One sigma of the terms that an IMU of a grade may have and that are not drawn, SI: a calibration's priors (docs/priors.md has the sources).
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

/// A grade of inertial systems as published (Xu 2024, table 1): from the best to the poorest, SI.
struct PublishedGrade {
  std::string_view name;
  std::array<double, 2> position_rate;          ///< m/s of position error
  std::array<double, 2> gyro_bias, accel_bias;  ///< rad/s, m/s^2
  std::array<double, 2> misalignment, scale;    ///< rad, relative
};
std::span<const PublishedGrade> published_grades();

/// An airliner's inertial system (Xu 2024, table 2).
struct AirlinerSystem {
  std::string_view name, gyro, aircraft;
  double position_rate;  ///< m/s of position error
  double gyro_bias;      ///< rad/s
};
std::span<const AirlinerSystem> airliner_systems();
/// A system by its name; throws Error that lists the known ones.
const AirlinerSystem& airliner_system(std::string_view name);

}  // namespace imulab
