// Periodic lines in a spectrum: found as ordinates that stand out of those about them, taken out as sinusoids.
#pragma once

#include "imulab/noise/noise_fit.hpp"
#include "imulab/noise/spectrum.hpp"

#include <span>
#include <vector>

namespace imulab::noise {

struct WithoutLines {
  Spectrum spectrum;
  std::vector<NoiseLine> lines;  ///< by frequency
};

/// At most eight. An ordinate whose power over the median about it, by chance, one log of a thousand has, begins one; it is a line if one frequency
/// takes most of the power about it in every piece of the record.
WithoutLines without_lines(std::span<const double> rate, double interval_s);

}  // namespace imulab::noise
