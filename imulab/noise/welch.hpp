// Welch's averaged periodogram: what other tools plot, and fine enough to see lines. The coefficients come from another spectrum (spectrum.hpp).
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace imulab {

/// Two-sided density at frequencies (k + 1) spacing_hz, k from 0, without 0 and half the rate: [u^2/Hz].
struct WelchSpectrum {
  std::size_t pieces = 0;  ///< they overlap by half
  double spacing_hz = 0;
  std::vector<double> density;
};

/// Each piece of `length` readings less its mean, through a Hann window (periodic). Throws Error for a length that is no power of two, below 8, or
/// longer than the record.
WelchSpectrum welch_spectrum(std::span<const double> rate, double interval_s, std::size_t length);

}  // namespace imulab
