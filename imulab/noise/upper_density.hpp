// The largest density that a log permits at each frequency, from the likelihood of its spectrum.
//
// It is the largest density at this frequency of all models whose -2 ln likelihood exceeds the least one by at most a quantile of chi-square with one
// degree of freedom: the one-sided bound of a likelihood profile. Frequencies at which the model does not fit have the chi-square bound of the
// measured power instead, if that is larger. Quantization is left out: its error in angle or velocity does not grow with time, and white noise above
// its spectrum would.
#pragma once

#include "imulab/noise.hpp"
#include "imulab/noise/noise_terms.hpp"
#include "imulab/noise/spectrum.hpp"

#include <vector>

namespace imulab::noise {

/// Returns upper bounds at increasing frequencies between the reach of the log and half the rate. `widening`: factor of all -2 ln likelihoods.
std::vector<UpperDensity> upper_densities(const ChosenModel& model, const Spectrum& spectrum, double half_rate_hz, double confidence,
                                          double widening);

}  // namespace imulab::noise
