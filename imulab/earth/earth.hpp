// WGS-84: normal gravity and the rotation of the Earth.
#pragma once

#include <Eigen/Core>

namespace imulab {

inline constexpr double earth_rate = 7.292115e-5;  // rad/s, WGS-84

/// Magnitude of WGS-84 normal gravity [m/s^2] at latitude [rad] and height [m] (GeographicLib).
double normal_gravity(double latitude, double height);

/// Earth's rotation rate in east-north-up axes [rad/s].
Eigen::Vector3d earth_rate_enu(double latitude);

}  // namespace imulab
