// Flicker and other first-order processes for tests, made otherwise than imulab's simulation makes them: independent processes an octave apart.
#pragma once

#include "imulab/core/random.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <span>
#include <vector>

namespace imulab {

/// Adds a first-order Gauss-Markov process of this standard deviation and correlation time, each sample its exact mean over the interval.
inline void add_process(std::span<double> rate, double sigma, double time, double interval, const RandomStream& draws) {
  const double x = interval / time, decay = std::exp(-x), kept = -std::expm1(-x) / x;
  // The state's and the mean's driven parts have these standard deviations, and the mean shares a part with the state. The mean's variance by its
  // series where rounding would spoil it.
  const double of_state = -std::expm1(-2 * x), shared = std::pow(std::expm1(-x), 2) / x;
  const double of_mean = x > 1e-2 ? (2 * x + 4 * std::expm1(-x) - std::expm1(-2 * x)) / (x * x) : x * (2.0 / 3 - x / 2);
  const double driven = sigma * std::sqrt(of_state), mean_shared = sigma * shared / std::sqrt(of_state),
               mean_own = sigma * std::sqrt(std::max(0.0, of_mean - shared * shared / of_state));
  // The mean's own part is white: for slow processes nothing beside them all.
  const bool own = x > 1e-3;
  constexpr std::size_t chunk = 512;
  std::array<double, 2 * chunk> z{};
  double state = sigma * draws.normal(0);
  for (std::size_t begin = 0; begin < rate.size(); begin += chunk) {
    const std::size_t n = std::min(chunk, rate.size() - begin);
    draws.normals(1 + begin * (own ? 2 : 1), std::span(z).first(own ? 2 * n : n));
    for (std::size_t k = 0; k < n; ++k) {
      rate[begin + k] += kept * state + mean_shared * z[k] + (own ? mean_own * z[n + k] : 0);
      state = decay * state + driven * z[k];
    }
  }
}

/// Adds flicker of density B^2 / (2 pi f): 28 processes an octave apart, of equal variance B^2 ln 2 / pi, from a 64th of the interval on; within 1 %
/// from 10^-6 of the rate on.
inline void add_flicker(std::span<double> rate, double B, double interval, std::uint64_t seed) {
  const double sigma = B * std::sqrt(std::numbers::ln2 / std::numbers::pi);
  for (int i = 0; i < 28; ++i)
    add_process(rate, sigma, interval / 64 * std::pow(2.0, i), interval, RandomStream(seed, "process " + std::to_string(i) + " of flicker"));
}

}  // namespace imulab
