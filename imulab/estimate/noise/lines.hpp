// Periodic lines in a spectrum: found as ordinates that stand out of the noise, taken out as sinusoids.
#pragma once

#include "imulab/estimate/noise/noise_terms.hpp"

#include <span>
#include <vector>

namespace imulab::noise {

/// What is left of the record's spectrum and model without its lines.
struct WithoutLines {
  Spectrum spectrum;
  ChosenModel model;
  std::vector<NoiseLine> lines;  ///< by frequency
};

/// At most eight. An ordinate whose power, by chance, no log of a million has, begins one; it is a line if one frequency takes most of the power
/// about it in every piece of the record.
WithoutLines without_lines(std::span<const double> rate, double interval_s, double resolution);

}  // namespace imulab::noise
