// Intervals of the noise coefficients from the profile of the likelihood:
//
//   profile(x) = the least misfit with the parameter fixed at x and all others fitted
//   interval   = all x with profile(x) - profile(best) <= chi-square (95 %, one degree of freedom) x widening
//
// The profile has correct coverage even if a coefficient is small and its likelihood is far from parabolic. If an interval contains zero, the
// coefficient is undetermined, with an upper bound.
#pragma once

#include "imulab/noise.hpp"
#include "imulab/noise/likelihood.hpp"

#include <optional>

namespace imulab::noise {

/// Returns the size for a parameter from its square: Q, N, B, K or sigma of a process. `widening`: factor on the required rise of the misfit.
NoiseCoefficient size_of(const SpectrumLikelihood& problem, const Point& best, int parameter, double widening);

/// Returns a correlation time or a cutoff: positive, and determined if the term is; a bound that is not found is infinite, or 0.
NoiseCoefficient scale_of(const SpectrumLikelihood& problem, const Point& best, int parameter, double widening);

/// Returns the ramp, which has a sign; `slope` was removed before. Bounds follow Student's distribution because the power has few degrees of freedom.
NoiseCoefficient ramp_of(const SpectrumLikelihood& problem, const Point& best, double slope, double widening);

/// Returns the interval of B and K together, from the range of their Allan variance over all B and K that the spectrum permits, at the time up to
/// `longest_s` where the interval is narrowest. Empty if zero is not excluded at any time, or if the model does not have both. `largest_B`,
/// `largest_K`: their upper bounds.
std::optional<JointNoise> joint_of(const SpectrumLikelihood& problem, const Point& best, double largest_B, double largest_K, double longest_s,
                                   double widening);

}  // namespace imulab::noise
