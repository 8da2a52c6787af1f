// A turn from rest to rest: a trapezoid of rate, or a triangle where the turn is too short to reach the rate.
#pragma once

#include <algorithm>
#include <cmath>

namespace imulab {

/// The default acceleration of a procedure's turn: 50 deg/s^2.
inline constexpr double default_acceleration_dps2 = 50;

/// Duration [s] of a turn by `angle` with at most `rate` and with `acceleration`, in one unit of angle.
inline double turn_duration(double angle, double rate, double acceleration) {
  const double way = std::abs(angle), top = std::abs(rate);
  if (way < top * top / acceleration) return 2 * std::sqrt(way / acceleration);
  return way / top + top / acceleration;
}

struct TurnState {
  double angle, rate;
};
/// Where that turn is `t` seconds after it began; `rate` is above 0, the angle has a sign.
inline TurnState turn_state(double angle, double rate, double acceleration, double t) {
  const double way = std::abs(angle), sign = angle < 0 ? -1 : 1, from_end = turn_duration(way, rate, acceleration) - t;
  const double ramp = std::min(rate / acceleration, std::sqrt(way / acceleration)), top = ramp * acceleration;
  if (t <= 0) return {0, 0};
  if (t < ramp) return {sign * (0.5 * acceleration * t * t), sign * (acceleration * t)};
  if (from_end >= ramp) return {sign * (top * (t - 0.5 * ramp)), sign * top};
  if (from_end > 0) return {sign * (way - 0.5 * acceleration * from_end * from_end), sign * (acceleration * from_end)};
  return {sign * way, 0};
}

}  // namespace imulab
