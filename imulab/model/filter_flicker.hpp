// Flicker as the covariance of a filter carries it: with one state in place of the 14 of sensor_noise.hpp.
#pragma once

#include <cmath>
#include <numbers>

namespace imulab {

/// One first-order process with a noise of its own, of a series whose times are in a ratio and whose sum has the power of flicker. Those that are
/// faster count as white, those that are slower as a walk that has begun long ago. Its Allan deviation is 0.664 B within 11 % from 10 to 1000 s.
struct FilterFlicker {
  static constexpr double time = 60, ratio = 32;  // s; a coast of ten seconds to ten minutes has its sigma within 4 %
  static constexpr double slower = 3;             // processes: up to three weeks
  double sigma;                                   // of the process, as of any of the series
  double white;                                   // density
  double walk;                                    // growth of the standard deviation [1/sqrt(s)]
  double start;                                   // standard deviation of the walk at the start

  // Of variances s^2 at steps L of ln(time), power 2 s^2 t / (1 + (w t)^2): the sum is s^2 pi / (w L) = B^2 / w.
  explicit FilterFlicker(double B)
      : sigma(B * std::sqrt(std::log(ratio) / std::numbers::pi)),
        white(sigma * std::sqrt(2 * time / (ratio - 1))),
        walk(sigma * std::sqrt(2 / time / (ratio - 1))),
        start(sigma * std::sqrt(slower)) {}
};

}  // namespace imulab
