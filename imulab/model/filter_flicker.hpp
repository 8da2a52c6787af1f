// Flicker in the covariance of a filter: one state instead of the 14 of sensor_noise.hpp.
#pragma once

#include <cmath>
#include <numbers>

namespace imulab {

/// One first-order process with a noise of its own, from a series with a constant ratio of correlation times and a sum with the power of flicker.
/// Faster processes count as white noise, slower ones as a random walk. The Allan deviation is 0.664 B within 11 % from 10 to 1000 s.
struct FilterFlicker {
  static constexpr double time = 60, ratio = 32;  // s; for a coast of 10 s to 10 min the sigma is within 4 %
  static constexpr double slower = 3;             // number of processes: up to three weeks
  double sigma;                                   // standard deviation of the process, equal for all of the series
  double white;                                   // density of the white noise
  double walk;                                    // growth of the standard deviation [1/sqrt(s)]
  double start;                                   // standard deviation of the walk at the start

  // Processes with variances s^2 at steps L of ln(time) and power 2 s^2 t / (1 + (w t)^2) have the sum s^2 pi / (w L) = B^2 / w.
  explicit FilterFlicker(double B)
      : sigma(B * std::sqrt(std::log(ratio) / std::numbers::pi)),
        white(sigma * std::sqrt(2 * time / (ratio - 1))),
        walk(sigma * std::sqrt(2 / time / (ratio - 1))),
        start(sigma * std::sqrt(slower)) {}
};

}  // namespace imulab
