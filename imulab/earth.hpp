// WGS-84: radii of curvature, normal gravity and the rotation of the Earth, east-north-up.
//
// Example:
//   const double g = normal_gravity(52 * unit::deg, 100);  // 9.8122 m/s^2
//   const Vector3d rate = earth_rate_enu(52 * unit::deg);  // rad/s
//
// Latitudes are geodetic [rad], heights above the ellipsoid [m]. Normal gravity is the closed form of the level ellipsoid; it equals GeographicLib's
// NormalGravity within 1e-12 m/s^2 from 1 km below the ellipsoid upward. Actual gravity differs from normal gravity by up to a few 1e-4 of g. Safe on
// any thread.
#pragma once

#include "imulab/eigen.hpp"

namespace imulab {

inline constexpr double earth_rate = 7.292115e-5;  // rad/s, WGS-84

/// Returns the magnitude of WGS-84 normal gravity [m/s^2] at geodetic `latitude` [rad] and `height` above the ellipsoid [m]. Throws Error for a
/// latitude beyond a pole, for example one in degrees.
double normal_gravity(double latitude, double height);

/// Returns the Earth's rotation rate [rad/s] in east-north-up axes at geodetic `latitude` [rad].
Eigen::Vector3d earth_rate_enu(double latitude);

/// Properties of the Earth at one place, in east-north-up axes.
struct LocalEarth {
  double sin_latitude, cos_latitude;
  double meridian_radius, transverse_radius;  // RM + h (north), RN + h (east) [m]: radii of curvature of the ellipsoid plus height
  Eigen::Vector3d rate;                       // rotation rate of the Earth [rad/s]
  Eigen::Vector3d gravity;                    // normal gravity including its north component [m/s^2]

  /// Returns the rotation rate [rad/s] of the east-north-up axes relative to the Earth (w_en_n) at `velocity` (east-north-up [m/s]); infinite at the
  /// poles.
  Eigen::Vector3d transport_rate(const Eigen::Vector3d& velocity) const {
    const double east = velocity.x() / transverse_radius;
    return {-velocity.y() / meridian_radius, east, east * sin_latitude / cos_latitude};
  }
};

/// Returns these properties at geodetic `latitude` [rad] and `height` above the ellipsoid [m].
LocalEarth local_earth(double latitude, double height);

}  // namespace imulab
