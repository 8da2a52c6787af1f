// Densities of the noise terms in a bin of the spectrum: two-sided [u^2/Hz], of means over the transform's interval.
#pragma once

#include "imulab/estimate/noise/spectrum.hpp"

namespace imulab::noise {

/// Of Q^2, B^2, K^2 = 1 (model/noise.hpp); that of N^2 is 1.
struct Densities {
  double Q = 0, B = 0, K = 0;
};
Densities unit_densities(const SpectrumBin& bin);

/// Of a first-order Gauss-Markov process of unit variance, and its derivative by the logarithm of the correlation time.
struct MarkovDensity {
  double value = 0, by_log_time = 0;
};
MarkovDensity markov_density(const SpectrumBin& bin, double time_s);

/// A Butterworth filter's share of the power of white noise, and its derivative by the logarithm of the cutoff. Of means over many readings: with the
/// frequencies that averaging folds in.
struct Passed {
  double red = 1, red_by_log_cutoff = 0;      ///< at the bin's frequency: of noise that falls with frequency
  double white = 1, white_by_log_cutoff = 0;  ///< of white noise
};
Passed passed(const SpectrumBin& bin, double cutoff_hz, int order);

}  // namespace imulab::noise
