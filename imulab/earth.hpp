// WGS-84: radii of curvature, normal gravity and the rotation of the Earth, east-north-up.
//
// Example:
//   const double g = normal_gravity(52 * unit::deg, 100);  // 9.8122 m/s^2
//   const Vector3d rate = earth_rate_enu(52 * unit::deg);  // rad/s
//
// Latitudes are geodetic [rad], heights above the ellipsoid [m]. Gravity is the closed form of the level ellipsoid, equal to GeographicLib's
// NormalGravity within 1e-12 m/s^2 from 1 km below the ellipsoid upward; the gravity of a place differs from it by up to some 1e-4. Safe
// on any thread.
#pragma once

#include "imulab/eigen.hpp"

namespace imulab {

inline constexpr double earth_rate = 7.292115e-5;  // rad/s, WGS-84

/// Magnitude of WGS-84 normal gravity [m/s^2] at geodetic latitude [rad] and height above the ellipsoid [m], in closed form as in local_earth. Throws
/// Error for a latitude beyond a pole, as one in degrees is:
///
///   normal_gravity(52 * unit::deg, 100)   // 9.8122 m/s^2
double normal_gravity(double latitude, double height);

/// Earth's rotation rate in east-north-up axes [rad/s].
Eigen::Vector3d earth_rate_enu(double latitude);

/// The Earth at one place, in east-north-up axes.
struct LocalEarth {
  double sin_latitude, cos_latitude;
  double meridian_radius, transverse_radius;  // RM + h (north), RN + h (east) [m]: radii of curvature of the ellipsoid and the height
  Eigen::Vector3d rate;                       // of the Earth's rotation [rad/s]
  Eigen::Vector3d gravity;                    // normal gravity, north component included [m/s^2]

  /// Rate of the east-north-up axes against the Earth at this velocity [rad/s] (w_en_n); infinite at the poles.
  Eigen::Vector3d transport_rate(const Eigen::Vector3d& velocity) const {
    const double east = velocity.x() / transverse_radius;
    return {-velocity.y() / meridian_radius, east, east * sin_latitude / cos_latitude};
  }
};

/// At geodetic latitude [rad] and height [m]. Gravity is the closed form of the level ellipsoid, equal to GeographicLib's NormalGravity within
/// 1e-12 m/s^2 from 1 km below the ellipsoid upward.
LocalEarth local_earth(double latitude, double height);

}  // namespace imulab
