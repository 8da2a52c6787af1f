// Grades of IMU: what a unit of a kind departs from the ideal before calibration, as one sigma of a draw.
#pragma once

#include "imulab/model/noise.hpp"

#include <array>
#include <span>
#include <string_view>

namespace imulab {

/// One-sigma spreads, SI; each coefficient of a unit is drawn on its own.
struct Grade {
  std::string_view name;
  double gyro_bias, accel_bias;                    ///< rad/s, m/s^2
  double gyro_scale, accel_scale;                  ///< relative
  double gyro_misalignment, accel_misalignment;    ///< rad; gyros: all six; accelerometers: the three non-orthogonalities
  double g_sensitivity;                            ///< (rad/s)/(m/s^2)
  NoiseModel gyro_noise, accel_noise;              ///< resolution and range in SI: the raw unit of a drawn unit
};

/// strategic, navigation, tactical, mems.
std::span<const Grade> grades();

/// A grade by its name; throws Error that lists the known ones.
const Grade& grade(std::string_view name);

/// What a grade of inertial system is, as published (Xu 2024, table 1): from the best to the poorest, SI.
struct PublishedGrade {
  std::string_view name;
  std::array<double, 2> position_rate;                ///< m/s of position error
  std::array<double, 2> gyro_bias, accel_bias;        ///< rad/s, m/s^2
  std::array<double, 2> misalignment, scale;          ///< rad, relative
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
