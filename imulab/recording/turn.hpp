// The duration of a turn from rest to rest.
#pragma once

#include <cmath>

namespace imulab {

/// The default acceleration of a procedure's turn: 50 deg/s^2.
inline constexpr double default_acceleration_dps2 = 50;

/// Duration [s] of a turn by `angle` with at most `rate` and with `acceleration`, in one unit of angle: a trapezoid of
/// rate, or a triangle where the turn is too short to reach the rate.
inline double turn_duration(double angle, double rate, double acceleration) {
  const double way = std::abs(angle), top = std::abs(rate);
  if (way < top * top / acceleration) return 2 * std::sqrt(way / acceleration);
  return way / top + top / acceleration;
}

}  // namespace imulab
