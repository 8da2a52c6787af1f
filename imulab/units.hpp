// Customary units as factors to SI. The library uses SI and radians internally: multiply inputs and divide outputs by these factors.
//
// Example:
//   const double bias = 5 * unit::deg_per_h;         // rad/s
//   const double shown = bias / unit::deg_per_h;     // 5
//   session.site.latitude = 45 * unit::deg;
#pragma once

#include <numbers>

namespace imulab::unit {

inline constexpr double deg = std::numbers::pi / 180;
inline constexpr double arcsec = deg / 3600;
inline constexpr double deg_per_h = deg / 3600;
inline constexpr double deg_per_sqrt_h = deg / 60;  // angle random walk: rad/sqrt(s) = rad/s/sqrt(Hz)
inline constexpr double g = 9.80665;                // m/s^2, the standard acceleration of free fall (exact)
inline constexpr double ug = 1e-6 * g;
inline constexpr double ug_per_sqrt_hz = 1e-6 * g;
inline constexpr double ppm = 1e-6;
inline constexpr double hour = 3600;            // s
inline constexpr double year = 365.25 * 86400;  // s, Julian
inline constexpr double nmi = 1852;             // m (exact)
inline constexpr double nmi_per_h = nmi / hour;

}  // namespace imulab::unit
