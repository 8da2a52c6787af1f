// The noise terms of one sensor axis as samples: means over the sample's interval, each term from its own random streams.
#pragma once

#include "imulab/core/random.hpp"
#include "imulab/eigen.hpp"
#include "imulab/grade.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <span>
#include <string>

namespace imulab {

// Flicker noise as first-order processes: simulations draw their sum, error budgets propagate their covariance.

/// Power B^2 / (2 pi f): processes z' = -pole z + gain u, all driven by one white noise u of unit density, plus `direct` u; their sum is a half-order
/// integral of u. The correlation times are 1, 4, 16, ... 4^13 sample intervals.
struct Flicker {
  static constexpr int processes = 14;
  static constexpr double times_ratio = 4;  // ratio of successive correlation times
  using Array = Eigen::Array<double, processes, 1>;
  Array pole, gain;  // 1/s, SI of the output
  double direct;     // for the faster processes, which follow the white noise: a geometric series of pole^-1/2

  // (j w)^-1/2 = 1/pi integral of p^1/2 / (j w + p) d(ln p), with poles p at equal steps of ln p.
  Flicker(double B, double interval) {
    const double weight = B * std::log(times_ratio) / std::numbers::pi, fastest = 1 / interval;
    for (int m = 0; m < processes; ++m) pole(m) = fastest * std::pow(times_ratio, -m);
    gain = weight * pole.sqrt();
    direct = weight / std::sqrt(fastest) / (std::sqrt(times_ratio) - 1);
  }
};

/// The covariance of flicker at two times.
class FlickerCovariance {
 public:
  FlickerCovariance(double B, double interval_s) : flicker_(B, interval_s) {
    for (Eigen::Index j = 0; j < Flicker::processes; ++j)
      weight_(j) = flicker_.gain(j) * (flicker_.gain / (flicker_.pole + flicker_.pole(j))).sum();  // one driver for all
  }
  double between(double lag) const { return (weight_ * (-flicker_.pole * lag).exp()).sum(); }
  /// Returns the variance of the mean over a time.
  double of_mean(double time) const {
    const Flicker::Array x = flicker_.pole * time;
    // 2 (x - 1 + exp(-x)) / x^2, as a series if rounding would dominate.
    const Flicker::Array averaged = (x > 1e-3).select(2 * (x - 1 + (-x).exp()) / x.square(), 1 - x / 3);
    return (weight_ * averaged).sum() + flicker_.direct * flicker_.direct / time;
  }

 private:
  Flicker flicker_;
  Flicker::Array weight_;
};

/// Noise of one axis. Flicker is the sum of the processes of Flicker, with the power of means over the sample's interval within 2 % from 10^5
/// intervals to half the sample rate. It begins in its stationary state; the rate random walk begins at zero.
class AxisNoise {
 public:
  /// `purpose` names the streams, for example "gyro.x noise of recording.csv".
  AxisNoise(const NoiseModel& model, double interval_s, std::uint64_t seed, const std::string& purpose);

  /// Returns true if there are terms with memory, or constant terms.
  bool slow() const;
  /// Adds turn-on bias, ramp, flicker and random walk to a whole recording, sample by sample.
  void add_slow(std::span<double> recording) const;
  /// Adds white and quantization noise to samples from `begin` on; parts of a recording are independent.
  void add_fast(std::size_t begin, std::span<double> out) const;

 private:
  Flicker::Array stationary_draw() const;

  NoiseModel model_;
  double interval_s_;
  double bias_, ramp_;             // constant errors of this recording
  std::array<double, 4> direct_;   // weights of the last draws of the flicker
  Flicker::Array decay_, driven_;  // propagation of the flicker over one sample
  RandomStream white_, quantization_, flicker_, walk_, start_;
};

}  // namespace imulab
