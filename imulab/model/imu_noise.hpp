// The noise of an IMU as its logs at rest tell it: coefficients with intervals. Terms as in model/noise.hpp.
#pragma once

#include "imulab/model/noise.hpp"

#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

namespace imulab {

/// Unit as in NoiseModel. Where the interval holds zero the coefficient is not determined: value and standard uncertainty are NaN, and `upper` bounds
/// its size with 95 %.
struct NoiseCoefficient {
  double value = 0, standard_uncertainty = 0;
  double lower = 0, upper = 0;  ///< 95 %
  bool determined = false;
};
/// One of which no more is known than this bound.
inline NoiseCoefficient undetermined_below(double upper) { return {NAN, NAN, 0, upper, false}; }

/// A first-order Gauss-Markov process: standard deviation [u] and correlation time [s]. Two-sided density 2 sigma^2 time / (1 + (2 pi f time)^2).
struct MarkovTerm {
  NoiseCoefficient sigma, time;
};

/// Of one axis.
struct NoiseCoefficients {
  NoiseCoefficient Q, N, B, K, R;
  std::vector<MarkovTerm> markov;  ///< by falling correlation time
};

/// What each term adds to the Allan variance over an averaging time [u^2] (IEEE Std 952); a term that is not determined adds nothing.
struct AllanTerms {
  double Q = 0, N = 0, B = 0, K = 0, R = 0, markov = 0;
  double sum() const { return Q + N + B + K + R + markov; }
};
AllanTerms allan_variance(const NoiseCoefficients& noise, double tau_s);

/// Axes without coefficients (constant readings) have none.
struct ImuNoise {
  std::string recording;
  double interval_s = 0;
  std::string gyro_unit, accel_unit;  ///< of u: "rad/s", "m/s^2", or "count"
  std::array<std::optional<NoiseCoefficients>, 3> gyro, accel;
};

/// The sizes of a triad's terms: the root mean square over its axes of what is determined, 0 where it is on no axis. Throws Error for readings in
/// counts, or where N is determined on no axis. Markov processes are left out: NoiseModel has none.
NoiseModels noise_sizes(const ImuNoise& noise);

}  // namespace imulab
