// Noise for a Kalman filter that is not too sure of itself: white noise, at most two first-order Gauss-Markov processes and a random walk whose
// spectrum is nowhere below a given one.
//
//   S_M(f) = N^2 + sum of sigma^2 m(f; time) + K^2 k(f) >= S_u(f),   1 / (10 horizon) <= f <= half the rate
//
// with the densities m and k of sampled states, as a filter has them. A linear filter with the model S_M then states at least its true covariance,
// whatever its gains (Langel, Garcia Crespillo and Joerger 2020). For fixed times the model is linear in N^2, sigma^2 and K^2: the mean of S_M / S_u
// over the logarithm of f is least in a corner of the permitted set, which linear programming finds.
#pragma once

#include "imulab/noise.hpp"

#include <optional>
#include <vector>

namespace imulab::noise {

/// The frequencies [Hz] at which a bound is compared, from 1 / (10 horizon) to half the rate.
std::vector<double> bound_frequencies(double interval_s, double horizon_s);

/// Returns the bounds at other frequencies: power laws between the given ones, below them rising as 1 / f^2, above them constant.
std::vector<UpperDensity> at_frequencies(const std::vector<UpperDensity>& upper, const std::vector<double>& hz);

/// Returns the tightest model above `upper`, which is given at the frequencies of `bound_frequencies`, with at most two processes. Fewer ones are
/// taken if they cost at most 1 %. `coast` remains empty. Throws Error for an interval or a density that is not positive.
NoiseBound tightest_bound(std::vector<UpperDensity> upper, double interval_s, const BoundOptions& options, int most_processes = 2);

/// White noise of each axis and a process each, all of one correlation time [s].
struct CommonProcess {
  double time = 0;
  std::vector<double> N, sigma;
};
/// Returns the tightest such models above the densities of several axes, for filters that have one correlation time and no walk. Empty without axes.
std::optional<CommonProcess> bounds_with_common_process(const std::vector<std::vector<UpperDensity>>& upper, double interval_s);

/// Returns the model's two-sided density at a frequency, for states at this interval.
double density(const NoiseBound& bound, double hz, double interval_s);

/// Sets the cost of a coast of 10 s, 60 s and the horizon: the Allan deviation of the bound over that of the coefficients without quantization.
void set_coasts(NoiseBound& bound, const NoiseCoefficients& fitted);

}  // namespace imulab::noise
