// Attitude from a rest: which way is up by gravity, which way is north by the Earth's rotation.
#pragma once

#include "imulab/navigation/increment.hpp"

#include <optional>
#include <span>

namespace imulab {

/// What one sample gives, and how long it lasted [s].
struct TimedIncrement {
  Increment increment;
  double interval = 0;
};

struct AlignmentSite {
  double latitude = 0;  // rad
  double gravity = 0;   // m/s^2
};

/// How far the sensors may be wrong: constant errors by their covariance in body axes, white noise by its density.
struct AlignmentSensors {
  Eigen::Matrix3d gyro_bias = Eigen::Matrix3d::Zero();   // (rad/s)^2
  Eigen::Matrix3d accel_bias = Eigen::Matrix3d::Zero();  // (m/s^2)^2
  std::optional<double> gyro_noise = {};                 // rad/s/sqrt(Hz); absent: estimated from the rest
  std::optional<double> accel_noise = {};                // m/s^2/sqrt(Hz); likewise
};

/// A heading known otherwise, at the end of the rest [rad]; sigma 0: exactly.
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
  double base_displacement = 0;            // of the base's own motion, one sigma as the filter needed it [m]
  double innovation_square = 0;            // mean square of the normalised innovations; 1 where noise and biases are as stated
  double innovation_correlation = 0;       // of each with the one before; 0 where they are white
  std::size_t updates = 0;                 // how many there were: both scatter by about 1/sqrt(updates)
  Eigen::Vector2d base_velocity;           // its motion at the end of the rest, east and north [m/s]; nothing but noise where it stands
  Eigen::Vector3d gyro_bias, accel_bias;   // what the rest shows of the constant errors, given their covariance
  Eigen::Matrix3d gyro_bias_covariance, accel_bias_covariance;
};

/// A shorter rest is refused (Unsupported) [s].
inline constexpr double shortest_alignment = 10;

/// Analytic: the gyros carry the body axes, the mean specific force of each half of the rest is a direction of gravity there, and the two directions
/// part by the rotation of the Earth. Sway averages out. The covariance has noise and biases, not the base's motion.
/// Error for a place within 0.1 deg of a pole and for forces that are not gravity's; Unsupported for a rest that is too short.
Alignment coarse_alignment(std::span<const TimedIncrement> rest, const AlignmentSite& site, const AlignmentSensors& sensors,
                           const std::optional<GivenHeading>& heading = {});

/// Kalman filter about the coarse attitude: the base goes nowhere, so that the horizontal displacement that the sensors give is error. How far the
/// base moves about its place is estimated where the innovations ask for it. Biases are states that start from their covariance.
FineAlignment fine_alignment(std::span<const TimedIncrement> rest, const AlignmentSite& site, const AlignmentSensors& sensors,
                             const std::optional<GivenHeading>& heading = {});

}  // namespace imulab
