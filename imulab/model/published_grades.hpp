// Published grades of inertial systems, and the temperatures of simulated IMUs.
#pragma once

#include "imulab/grade.hpp"

#include <array>
#include <optional>
#include <span>
#include <string_view>

namespace imulab {

/// The temperature at which a simulated IMU's thermal terms are zero, and its temperature range, degC.
inline constexpr double drawn_reference = 25;
inline constexpr std::array<double, 2> drawn_temperatures{0, 70};

/// A published grade of inertial systems (Xu 2024, table 1): from best to poorest, SI.
struct PublishedGrade {
  std::string_view name;
  std::array<double, 2> position_rate;          ///< rate of position error [m/s]
  std::array<double, 2> gyro_bias, accel_bias;  ///< rad/s, m/s^2
  std::array<double, 2> misalignment, scale;    ///< rad, relative
};
std::span<const PublishedGrade> published_grades();

/// An airliner's inertial system (Xu 2024, table 2).
struct AirlinerSystem {
  std::string_view name, gyro, aircraft;
  double position_rate;  ///< rate of position error [m/s]
  double gyro_bias;      ///< rad/s
};
std::span<const AirlinerSystem> airliner_systems();
/// Returns the system with this name; throws an Error that lists the known ones.
const AirlinerSystem& airliner_system(std::string_view name);

}  // namespace imulab
