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

/// Neighboring ordinates k of transforms of `length` samples, each the mean of `averaged` readings over `interval` [s].
struct SpectrumBin {
  double interval = 0;
  std::size_t averaged = 1, length = 0, first = 0, last = 0;  ///< k from first to last
  double count = 0;                                           ///< ordinates times transforms: degrees of freedom
  double power = 0;                                           ///< mean square times interval: two-sided density [u^2/Hz]
  double amplitude = 0, ramp = 0;  ///< of one ordinate of the whole record: the ordinate [u sqrt(s)], and that of a ramp of 1 u/s
  double low_hz() const { return (static_cast<double>(first) - 0.5) / (2 * interval * static_cast<double>(length)); }
  double high_hz() const { return (static_cast<double>(last) + 0.5) / (2 * interval * static_cast<double>(length)); }
  double middle_hz() const { return 0.5 * (low_hz() + high_hz()); }
};

/// The ordinates of one kind of transform, not yet binned.
struct SpectrumLevel {
  double interval = 0;
  std::size_t averaged = 1, first = 0, end = 0;  ///< the ordinates used
  double transforms = 0;
  std::vector<double> power;  ///< of every ordinate, as a bin's
  double hz(double k) const { return k / (2 * interval * static_cast<double>(power.size())); }
};

struct Spectrum {
  std::vector<SpectrumLevel> levels;  ///< from low to high frequency
  std::vector<SpectrumBin> bins;      ///< likewise
  double slope = 0;                   ///< of the line that was removed from the rate before [u/s]; amplitudes are without it
  double record_s = 0;                ///< length of the record
  double squares = 0;                 ///< of the last sinusoid in `without`: mean square of its fitted amplitude [u^2]
  double pieces = 0, piece_s = 0;     ///< fitted so often, in pieces so long
};

/// At least 64 readings are expected. Sinusoids of the frequencies `without` [Hz] are removed from every transform's readings, and the ordinates
/// beside them left out of the bins.
Spectrum spectrum_of(std::span<const double> rate, double interval_s, const std::vector<double>& without = {});

/// The frequency near `hz` whose sinusoid takes most power from pieces of the record of the given length [s].
double sharpened(std::span<const double> rate, double interval_s, double hz, double piece_s);

}  // namespace imulab::noise

namespace imulab {

// Welch's averaged periodogram: what other tools plot, and fine enough to see lines. The coefficients come from another spectrum (spectrum.hpp).

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
