// Which terms a spectrum needs, and how well the model then fits.
#pragma once

#include "imulab/noise/likelihood.hpp"
#include "imulab/noise/noise_fit.hpp"

#include <optional>
#include <vector>

namespace imulab::noise {

struct Agreement {
  double chi2_per_dof = 0;
  std::vector<NoiseMisfit> misfits;
};

struct Model {
  Problem problem;
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

}  // namespace imulab::noise
