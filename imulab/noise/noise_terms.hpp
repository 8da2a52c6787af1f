// Which terms a spectrum needs, and how well the model then fits.
#pragma once

#include "imulab/noise.hpp"
#include "imulab/noise/likelihood.hpp"
#include "imulab/noise/spectrum.hpp"

#include <optional>
#include <span>
#include <vector>

namespace imulab::noise {

struct Agreement {
  double chi2_per_dof = 0;
  std::vector<NoiseMisfit> misfits;
};

struct Model {
  SpectrumLikelihood problem;
  Point best;
  double misfit = 0;  ///< with Q^2 not negative
};

struct ChosenModel : Model {
  std::optional<Model> wider;  ///< with one process more, which the spectrum neither asks for nor excludes
  double highest_hz = 0;
  Agreement agreement;
};

/// Processes and a low-pass as far as each raises the likelihood by more than chance does; where the model then does not hold at high frequency, that
/// end is left out, at most down to a 32nd. Throws Unsupported where too little of the spectrum is left.
ChosenModel choose_terms(const Spectrum& spectrum, double half_rate_hz, double resolution);

// Periodic lines in a spectrum: found as ordinates that stand out of those about them, taken out as sinusoids.

struct WithoutLines {
  Spectrum spectrum;
  std::vector<NoiseLine> lines;  ///< by frequency
};

/// At most eight. An ordinate whose power over the median about it, by chance, one log of a thousand has, begins one; it is a line if one frequency
/// takes most of the power about it in every piece of the record.
WithoutLines without_lines(std::span<const double> rate, double interval_s);

}  // namespace imulab::noise
