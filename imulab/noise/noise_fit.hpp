// The noise coefficients of a rate at rest by maximum likelihood on its spectrum (Whittle), with intervals from the profile of the likelihood
// (docs/noise.md; the terms of IEEE Std 952, doi:10.1109/IEEESTD.1998.86153).
//
//   const NoiseFit fit = fit_noise(rate, 0.01);                   // readings at rest [rad/s], interval [s]
//   fit.N.value                                                   // angle random walk [rad/s/sqrt(Hz)]
//   fit.B.determined ? fit.B.value : fit.B.upper                  // or a 95 % bound
//
// Valid for stationary noise of 64 readings and more. Slow terms (B, K) need records that are long against the times at which they dominate.
#pragma once

#include "imulab/model/imu_noise.hpp"

#include <optional>
#include <span>
#include <vector>

namespace imulab {

/// A range of frequencies in which the spectrum is not the model's.
struct NoiseMisfit {
  double low_hz = 0, high_hz = 0, ratio = 1;  ///< measured power over the model's
};

/// A sinusoid in the readings, taken out of the spectrum: amplitude [u].
struct NoiseLine {
  double hz = 0;
  NoiseCoefficient amplitude;
};

/// The sensor's own: a Butterworth filter, before the readings are taken or digital at their rate.
struct LowPass {
  int order = 1;
  bool digital = false;
  NoiseCoefficient cutoff_hz;
};

/// The measured density and the model's, two-sided, at a frequency; on `count` degrees of freedom.
struct SpectrumPoint {
  double hz = 0, density = 0, model = 0, count = 0;
};

struct NoiseFit : NoiseCoefficients {
  std::optional<LowPass> low_pass;
  std::vector<NoiseLine> lines;         ///< by frequency; lines above half the rate appear at their alias below it
  double resolution = 0;                ///< step of the readings; 0: not rounded, or finely
  double chi2_per_dof = 0;              ///< of the power in some dozens of ranges of frequency
  double highest_hz = 0;                ///< higher frequencies were left out because the model does not hold there; else half the rate
  bool cut = false;                     ///< whether some were
  std::vector<NoiseMisfit> misfits;     ///< remaining misfits; all intervals are then widened by the root of chi2_per_dof
  std::vector<SpectrumPoint> spectrum;  ///< without the lines

  bool accepted() const { return misfits.empty(); }
};

/// Q, N, B, K and the ramp are always fitted; Markov processes (up to two), a low-pass and lines (up to eight) where the spectrum shows them. The
/// intervals of B and K also allow for one more process, as far as the spectrum does not exclude it. Throws Error for fewer than 64 readings, a
/// reading that is not finite or an interval that is not positive; Unsupported where the readings are constant. `step`: of rounded readings, 0 where
/// they are not rounded; absent: the step that the readings show.
NoiseFit fit_noise(std::span<const double> rate, double interval_s, std::optional<double> step = {});

/// The step of rounded readings, where enough of its multiples occur; 0 where none is seen.
double resolution_of(std::span<const double> rate);

}  // namespace imulab
