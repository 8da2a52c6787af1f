// Selection of the terms for a spectrum, and a test of the resulting model.
#pragma once

#include "imulab/noise.hpp"
#include "imulab/noise/likelihood.hpp"
#include "imulab/noise/spectrum.hpp"

#include <optional>
#include <span>
#include <vector>

namespace imulab::noise {

/// Bins in a range of at least 20 degrees of freedom and a third of an octave, with the sum of a value over the degrees of freedom.
struct PowerGroup {
  double low_hz, high_hz, count, sum;
};

/// Groups successive bins; `value_of` the bin of an index.
template <class ValueOf>
std::vector<PowerGroup> grouped(const std::vector<SpectrumBin>& bins, const ValueOf& value_of) {
  std::vector<PowerGroup> groups;
  for (std::size_t i = 0; i < bins.size(); ++i) {
    if (groups.empty() || (groups.back().count >= 20 && groups.back().high_hz > 1.25 * groups.back().low_hz))
      groups.push_back({bins[i].low_hz(), 0, 0, 0});
    groups.back().high_hz = bins[i].high_hz();
    groups.back().count += bins[i].count;
    groups.back().sum += bins[i].count * value_of(i);
  }
  return groups;
}

struct Agreement {
  double chi2_per_dof = 0;
  std::vector<NoiseMisfit> misfits;
};

struct Model {
  SpectrumLikelihood problem;
  Point best;
  double misfit = 0;  ///< misfit with nonnegative Q^2
};

struct ChosenModel : Model {
  std::optional<Model> wider;  ///< model with one more process, which the spectrum neither requires nor excludes
  double highest_hz = 0;
  Agreement agreement;
};

/// Adds processes and a low-pass if each raises the likelihood significantly. If the model is invalid at high frequencies, these are left out, at
/// most down to 1/32. With `model`, its terms are fitted and only a low-pass is chosen. Throws Unsupported if too little of the spectrum remains, or
/// if the log shows fewer processes than the model has.
ChosenModel choose_terms(const Spectrum& spectrum, double half_rate_hz, double resolution, const std::optional<NoiseModelTerms>& model = {});

// Periodic lines in a spectrum: ordinates above their neighborhood, removed as sinusoids.

struct WithoutLines {
  Spectrum spectrum;
  std::vector<NoiseLine> lines;  ///< sorted by frequency
};

/// Removes at most eight lines. A line begins with an ordinate whose power relative to the median near it occurs by chance in one log of a thousand;
/// it is a line if one frequency explains most of the power near it in every piece of the record.
WithoutLines without_lines(std::span<const double> rate, double interval_s);

}  // namespace imulab::noise
