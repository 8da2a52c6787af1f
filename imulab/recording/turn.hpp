// How long a turn from rest to rest takes.
#pragma once

#include <cmath>

namespace imulab {

/// What a procedure's turn speeds up and slows down with where it does not say: 50 deg/s^2.
inline constexpr double default_acceleration_dps2 = 50;

/// Seconds of a turn through `angle` at most at `rate`, speeding up and slowing down at `acceleration`, in one unit of angle: a trapezoid of
/// rate, or a triangle where the turn is too short to reach the rate.
inline double turn_duration(double angle, double rate, double acceleration) {
  const double way = std::abs(angle), top = std::abs(rate);
  if (way < top * top / acceleration) return 2 * std::sqrt(way / acceleration);
  return way / top + top / acceleration;
}

}  // namespace imulab
