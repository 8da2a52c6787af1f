// The spectrum of a rate at rest by cosine transforms, for a likelihood.
//
// The cosine transform (DCT-II) makes white noise and random walk exactly independent: a periodogram leaks the power of the walk, and a window
// reduces resolution at the lowest frequencies, which alone determine it. One transform of the record, averaged to at most 65536 samples, gives the
// low frequencies; transforms of shorter, less averaged pieces give the higher ones. Time is proportional to the length of the record.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace imulab::noise {

/// Successive ordinates k of transforms of `length` samples, each the mean of `averaged` readings over `interval` [s].
struct SpectrumBin {
  double interval = 0;
  std::size_t averaged = 1, length = 0, first = 0, last = 0;  ///< k from first to last
  double count = 0;                                           ///< number of ordinates times transforms: degrees of freedom
  double power = 0;                                           ///< mean square times interval: two-sided density [u^2/Hz]
  /// For one ordinate of the whole record: the ordinate [u sqrt(s)], and that of a ramp of 1 u/s.
  double amplitude = 0, ramp = 0;
  double low_hz() const { return (static_cast<double>(first) - 0.5) / (2 * interval * static_cast<double>(length)); }
  double high_hz() const { return (static_cast<double>(last) + 0.5) / (2 * interval * static_cast<double>(length)); }
  double middle_hz() const { return 0.5 * (low_hz() + high_hz()); }
};

/// The ordinates of one kind of transform before binning.
struct SpectrumLevel {
  double interval = 0;
  std::size_t averaged = 1, first = 0, end = 0;  ///< the ordinates used
  double transforms = 0;
  std::vector<double> power;  ///< density of every ordinate, as in a bin
  double hz(double k) const { return k / (2 * interval * static_cast<double>(power.size())); }
};

struct Spectrum {
  std::vector<SpectrumLevel> levels;  ///< from low to high frequency
  std::vector<SpectrumBin> bins;      ///< from low to high frequency
  double slope = 0;                   ///< slope of the line that was removed from the rate [u/s]; amplitudes exclude it
  double record_s = 0;                ///< length of the record
  double squares = 0;                 ///< for the last sinusoid in `without`: mean square of its fitted amplitude [u^2]
  double pieces = 0, piece_s = 0;     ///< number of fits and length of each piece
};

/// Requires 64 or more readings. Sinusoids of the frequencies `without` [Hz] are removed from all transforms, and adjacent ordinates from the bins.
Spectrum spectrum_of(std::span<const double> rate, double interval_s, const std::vector<double>& without = {});

/// Returns the frequency near `hz` whose sinusoid explains most power in pieces of the record of the given length [s].
double sharpened(std::span<const double> rate, double interval_s, double hz, double piece_s);

}  // namespace imulab::noise

namespace imulab {

// Welch's averaged periodogram: the usual plot of other tools, with enough resolution for lines. The coefficients use spectrum.hpp instead.

/// Two-sided density [u^2/Hz] at frequencies (k + 1) spacing_hz, k from 0, excluding 0 and half the rate.
struct WelchSpectrum {
  std::size_t pieces = 0;  ///< overlapping by half
  double spacing_hz = 0;
  std::vector<double> density;
};

/// Averages pieces of `length` readings minus their mean, with a periodic Hann window. Throws Error for a length that is not a power of two, below 8,
/// or longer than the record.
WelchSpectrum welch_spectrum(std::span<const double> rate, double interval_s, std::size_t length);

}  // namespace imulab
