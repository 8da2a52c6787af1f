// Grades of IMU: what a unit of a kind departs from the ideal before calibration, as one sigma of a draw.
#pragma once

#include "imulab/model/noise.hpp"

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

}  // namespace imulab
