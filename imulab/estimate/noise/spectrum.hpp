// The spectrum of a rate at rest by cosine transforms, for a likelihood.
//
// The cosine transform (DCT-II) makes white noise, and the random walk too, exactly independent: a periodogram leaks the walk's power, and a window
// costs resolution at the lowest frequencies, which alone determine it. One transform of the record, averaged to at most 65536 samples, gives the low
// frequencies; transforms of shorter pieces, less averaged, the higher ones. Time grows with the record's length.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace imulab::noise {

/// Neighboring ordinates k of transforms of `length` samples, each the mean over `interval` [s].
struct SpectrumBin {
  double interval = 0;
  std::size_t length = 0, first = 0, last = 0;  ///< k from first to last
  double count = 0;                             ///< ordinates times transforms: degrees of freedom
  double power = 0;                             ///< mean square times interval: two-sided density [u^2/Hz]
  double amplitude = 0, ramp = 0;               ///< of one ordinate of the whole record: the ordinate [u sqrt(s)], and that of a ramp of 1 u/s
  double low_hz() const { return (static_cast<double>(first) - 0.5) / (2 * interval * static_cast<double>(length)); }
  double high_hz() const { return (static_cast<double>(last) + 0.5) / (2 * interval * static_cast<double>(length)); }
};

struct Spectrum {
  std::vector<SpectrumBin> bins;  ///< from low to high frequency
  double slope = 0;               ///< of the line that was removed from the rate before [u/s]; amplitudes are without it
};

/// At least 64 readings are expected.
Spectrum spectrum_of(std::span<const double> rate, double interval_s);

/// Mean density over a bin of noise with a unit coefficient: Q^2, N^2, B^2, K^2 (model/noise.hpp).
struct Densities {
  double Q = 0, N = 1, B = 0, K = 0;
};
Densities unit_densities(const SpectrumBin& bin);

}  // namespace imulab::noise
