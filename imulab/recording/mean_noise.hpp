// The noise of a rest's mean: what its samples say of it, whether they are independent or not, and what rounded readings keep from it.
#pragma once

#include "imulab/recording/rest_means.hpp"

namespace imulab {

/// Per axis, raw. A mean of n samples has the variance sample^2 / n + rounding^2.
struct MeanNoise {
  SampleNoise sample;    ///< of one sample, were they independent: block means of a low-passed output scatter by more than single samples tell
  SampleNoise rounding;  ///< does not average out within a rest
  SampleNoise step;      ///< to which the readings are rounded; 0 where the noise is far larger
};

/// Pooled over the rests.
MeanNoise measure_mean_noise(const Recording& recording, const std::vector<RestMeans>& rests);

/// Variance of a rounded reading's mean about the true value, for white noise `sigma` before the rounding to steps `step`, over all places of the
/// true value between two steps: sum_k (q / (pi k))^2 / 2 exp(-4 pi^2 k^2 sigma^2 / q^2), q^2 / 12 without noise.
double rounding_variance(double step, double sigma);

/// The white noise before the rounding, from the standard deviation of the rounded readings.
double sigma_before_rounding(double step, double rounded_sigma);

}  // namespace imulab
