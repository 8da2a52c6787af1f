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

/// A Butterworth filter before the readings are taken; or one that runs at their rate, by the bilinear transform.
struct LowPassShape {
  int order = 0;  ///< 0: none
  bool digital = false;
  bool operator==(const LowPassShape&) const = default;
};

/// The share of the power that a filter passes, and its derivative by the logarithm of the cutoff. Of means over many readings: with the frequencies
/// that averaging folds in; of readings of a filter before them: with those that sampling folds in, one at frequency 0.
struct Passed {
  double red = 1, red_by_log_cutoff = 0;      ///< at the bin's frequency: of noise that falls with frequency
  double white = 1, white_by_log_cutoff = 0;  ///< of white noise
};
Passed passed(const SpectrumBin& bin, double cutoff_hz, const LowPassShape& shape);

}  // namespace imulab::noise
