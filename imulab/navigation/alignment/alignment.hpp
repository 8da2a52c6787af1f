// Attitude from a rest: gravity shows the vertical, the Earth's rotation shows north (docs/navigation.md).
//
//   const Alignment coarse = coarse_alignment(rest, {.latitude = 0.8, .gravity = 9.81}, sensors);
//   std::sqrt(coarse.covariance(2, 2))                            // one sigma of the heading [rad]
//
// A constant gyro error e east leaves e / (w_ie cos L) of heading, a constant accelerometer error b leaves b / g of tilt: the covariance includes
// both. Valid for rests of 10 s and more, within 89.9 deg of latitude.
#pragma once

#include "imulab/navigation/integration/increment.hpp"

#include <optional>
#include <span>

namespace imulab {

struct AlignmentSite {
  double latitude = 0;  // rad, at most 89.9 deg either way
  double gravity = 0;   // m/s^2
};

/// Errors of the sensors: constant ones by their covariance in body axes, white noise by its density.
struct AlignmentSensors {
  Eigen::Matrix3d gyro_bias = Eigen::Matrix3d::Zero();   // (rad/s)^2
  Eigen::Matrix3d accel_bias = Eigen::Matrix3d::Zero();  // (m/s^2)^2
  std::optional<double> gyro_noise = {};                 // rad/s/sqrt(Hz); absent: estimated from the rest
  std::optional<double> accel_noise = {};                // m/s^2/sqrt(Hz); likewise
};

/// A heading known from elsewhere, at the end of the rest [rad]; sigma 0: exactly.
struct GivenHeading {
  double value = 0, sigma = 0;
};

/// At the END of the rest. The covariance [rad^2] is that of phi, east-north-up, where C_nb = (I - [phi x]) C_nb of the truth.
struct Alignment {
  Eigen::Matrix3d C_nb = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

struct FineAlignment {
  Alignment attitude;
  double gyro_noise = 0, accel_noise = 0;  // the densities used
  double base_displacement = 0;            // of the base's own motion, one sigma as estimated by the filter [m]
  double innovation_square = 0;            // mean square of the normalized innovations; 1 where noise and biases are as stated
  double innovation_correlation = 0;       // of each with the one before; 0 where they are white
  std::size_t updates = 0;                 // their number: both figures scatter by about 1/sqrt(updates)
  Eigen::Vector2d base_velocity;           // at the end of the rest, east and north [m/s]; nothing but noise where the base does not move
  Eigen::Vector3d gyro_bias, accel_bias;   // estimates of the constant errors from the rest, given their covariance
  Eigen::Matrix3d gyro_bias_covariance, accel_bias_covariance;
};

/// A shorter rest is refused (Unsupported) [s].
inline constexpr double shortest_alignment = 10;

/// Analytic: the gyros carry the body axes, the mean specific force of each half of the rest is a direction of gravity there, and the two directions
/// differ by the rotation of the Earth. Sway averages out. The covariance includes noise and biases, but not the base's motion.
/// Throws Error for a place within 0.1 deg of a pole, for a mean force that differs from gravity by more than 5 %, and for a heading of a unit whose
/// forward axis is vertical; Unsupported for a rest that is too short.
Alignment coarse_alignment(std::span<const TimedIncrement> rest, const AlignmentSite& site, const AlignmentSensors& sensors,
                           const std::optional<GivenHeading>& heading = {});

/// Kalman filter about the coarse attitude: the base stays at its place, so the horizontal displacement that the sensors show is an error. The size
/// of the base's motion about its place is estimated where the innovations require it. Biases are states that start from their covariance. Throws as
/// coarse_alignment does, and Unsupported where no motion of a base explains the readings.
FineAlignment fine_alignment(std::span<const TimedIncrement> rest, const AlignmentSite& site, const AlignmentSensors& sensors,
                             const std::optional<GivenHeading>& heading = {});

}  // namespace imulab
