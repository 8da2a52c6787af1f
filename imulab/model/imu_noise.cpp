#include "imulab/model/imu_noise.hpp"

#include <cmath>
#include <numbers>

namespace imulab {

AllanTerms allan_variance(const NoiseCoefficients& noise, double tau_s) {
  const auto square = [](const NoiseCoefficient& c) { return c.determined ? c.value * c.value : 0; };
  AllanTerms out;
  out.Q = 3 * square(noise.Q) / (tau_s * tau_s);
  out.N = square(noise.N) / tau_s;
  out.B = 2 * std::numbers::ln2 / std::numbers::pi * square(noise.B);
  out.K = square(noise.K) * tau_s / 3;
  out.R = square(noise.R) * tau_s * tau_s / 2;
  for (const MarkovTerm& term : noise.markov) {
    // 2 sigma^2 t / tau (1 - t / (2 tau) (3 - 4 exp(-x) + exp(-2 x))), x = tau / t; its series where rounding would spoil it.
    const double x = tau_s / term.time.value;
    const double bracket = x > 1e-3 ? 1 - (3 - 4 * std::exp(-x) + std::exp(-2 * x)) / (2 * x) : x * x / 3;
    out.markov += 2 * square(term.sigma) / x * bracket;
  }
  return out;
}

}  // namespace imulab
