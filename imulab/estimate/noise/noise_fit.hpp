// The noise coefficients of a rate at rest by maximum likelihood on its spectrum (Whittle), with intervals from the profile of the likelihood.
#pragma once

#include "imulab/model/imu_noise.hpp"

#include <array>
#include <span>
#include <string>
#include <vector>

namespace imulab {

/// A range of frequencies in which the spectrum is not the model's.
struct NoiseMisfit {
  double low_hz = 0, high_hz = 0, ratio = 1;  ///< measured power over the model's
};

struct NoiseFit : NoiseCoefficients {
  double chi2_per_dof = 0;           ///< of the power in some dozens of ranges of frequency
  bool accepted = false;             ///< no misfit is left
  double highest_hz = 0;             ///< higher frequencies were left out because the model does not hold there; else half the rate
  bool cut = false;                  ///< whether some were
  std::vector<NoiseMisfit> misfits;  ///< what is left; all intervals are then widened by the root of chi2_per_dof
};

/// Throws Error for fewer than 64 readings, a reading that is not finite or an interval that is not positive; Unsupported where the readings are
/// constant.
NoiseFit fit_noise(std::span<const double> rate, double interval_s);

}  // namespace imulab
