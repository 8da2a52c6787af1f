// Flicker noise as first-order processes: simulations draw their sum, error budgets propagate their covariance.
#pragma once

#include <Eigen/Core>

#include <cmath>
#include <numbers>

namespace imulab {

/// Power B^2 / (2 pi f): processes z' = -pole z + gain u, all driven by one white noise u of unit density, and `direct` u besides; their sum is a
/// half-order integral of u. Correlation times of 1, 4, 16, ... 4^13 sample intervals.
struct Flicker {
  static constexpr int processes = 14;
  static constexpr double times_ratio = 4;  // of neighboring correlation times
  using Array = Eigen::Array<double, processes, 1>;
  Array pole, gain;  // 1/s, SI of the output
  double direct;     // of the faster ones, which follow the white noise: a geometric series of pole^-1/2

  // (j w)^-1/2 = 1/pi integral of p^1/2 / (j w + p) d(ln p): the poles p at equal steps of ln p.
  Flicker(double B, double interval) {
    const double weight = B * std::log(times_ratio) / std::numbers::pi, fastest = 1 / interval;
    for (int m = 0; m < processes; ++m) pole(m) = fastest * std::pow(times_ratio, -m);
    gain = weight * pole.sqrt();
    direct = weight / std::sqrt(fastest) / (std::sqrt(times_ratio) - 1);
  }
};

/// Covariance of flicker at two times.
class FlickerCovariance {
 public:
  FlickerCovariance(double B, double interval_s) : flicker_(B, interval_s) {
    for (Eigen::Index j = 0; j < Flicker::processes; ++j)
      weight_(j) = flicker_.gain(j) * (flicker_.gain / (flicker_.pole + flicker_.pole(j))).sum();  // one driver for all
  }
  double between(double lag) const { return (weight_ * (-flicker_.pole * lag).exp()).sum(); }
  /// Variance of the mean over a time.
  double of_mean(double time) const {
    const Flicker::Array x = flicker_.pole * time;
    // 2 (x - 1 + exp(-x)) / x^2; its series where rounding would spoil it.
    const Flicker::Array averaged = (x > 1e-3).select(2 * (x - 1 + (-x).exp()) / x.square(), 1 - x / 3);
    return (weight_ * averaged).sum() + flicker_.direct * flicker_.direct / time;
  }

 private:
  Flicker flicker_;
  Flicker::Array weight_;
};

}  // namespace imulab
