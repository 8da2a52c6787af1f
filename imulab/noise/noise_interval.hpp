// Intervals of the noise coefficients by the profile of the likelihood:
//
//   profile(x) = the least misfit with the parameter fixed at x and all others fitted
//   interval   = all x with profile(x) - profile(best) <= chi-square (95 %, one degree of freedom) x widening
//
// The profile keeps its coverage where a coefficient is small and its likelihood is far from a parabola. An interval that contains zero leaves the
// coefficient undetermined, with an upper bound.
#pragma once

#include "imulab/noise.hpp"
#include "imulab/noise/likelihood.hpp"

namespace imulab::noise {

/// The size behind a parameter, from its square: of Q, N, B, K or a process's sigma. `widening`: how much larger than by chance alone a rise of the
/// misfit has to be.
NoiseCoefficient size_of(const SpectrumLikelihood& problem, const Point& best, int parameter, double widening);

/// A correlation time or a cutoff: positive, always determined where the term is; a bound that is not found is infinite, or 0.
NoiseCoefficient scale_of(const SpectrumLikelihood& problem, const Point& best, int parameter, double widening);

/// The ramp has a sign; `slope` was removed before. Bounds as Student's distribution has them for a power known by few degrees of freedom.
NoiseCoefficient ramp_of(const SpectrumLikelihood& problem, const Point& best, double slope, double widening);

}  // namespace imulab::noise
