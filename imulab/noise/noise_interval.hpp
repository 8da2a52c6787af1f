// Intervals of the noise coefficients: where the likelihood, maximized over all other terms, is within chi-square of its maximum.
#pragma once

#include "imulab/model/imu_noise.hpp"
#include "imulab/noise/likelihood.hpp"

namespace imulab::noise {

/// The size behind a parameter: of Q, N, B, K or a process's sigma. `widening`: how much larger than by chance alone a rise of the misfit has to be.
NoiseCoefficient size_of(const Problem& problem, const Point& best, int parameter, double widening);

/// Of a correlation time or a cutoff: positive, always determined where the term is; a bound that is not found is infinite, or 0.
NoiseCoefficient scale_of(const Problem& problem, const Point& best, int parameter, double widening);

/// The ramp has a sign; `slope` was removed before. Bounds as Student's distribution has them for a power known by few degrees of freedom.
NoiseCoefficient ramp_of(const Problem& problem, const Point& best, double slope, double widening);

}  // namespace imulab::noise
