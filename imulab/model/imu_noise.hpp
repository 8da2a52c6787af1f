// The noise of an IMU: the terms of a sensor's noise as a model, and their coefficients with intervals as logs at rest determine them. Names and
// units of the terms are those of IEEE Std 952.
#pragma once

#include "imulab/core/random.hpp"

#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

namespace imulab {

// Errors of a triad's readings that are not in the sensor model: noise terms with the names of IEEE Std 952, and the limits of its output.

/// SI of the triad's output u: rad/s or m/s^2. The coefficients Q, N, B and K are exact sizes; turn-on bias and rate ramp are constant in a
/// recording and drawn anew for each, by axis (fixed: the same on every axis). Zero: the term is absent.
struct NoiseModel {
  double Q = 0;           ///< quantization [u s]: white noise of the output's integral. Allan deviation sqrt(3) Q / tau
  double N = 0;           ///< angle or velocity random walk [u/sqrt(Hz)]: N / sqrt(tau)
  double B = 0;           ///< bias instability, flicker [u]: 0.664 B at its plateau
  double K = 0;           ///< rate random walk [u/sqrt(s)]: K sqrt(tau / 3)
  Spread R{};             ///< rate ramp [u/s]: R tau / sqrt(2)
  Spread turn_on{};       ///< bias of a turn-on [u]
  double resolution = 0;  ///< of a reading, in the raw unit (an increment's over its interval)
  double range = 0;       ///< largest reading, either way, likewise
  bool operator==(const NoiseModel&) const = default;
};

/// Noise of one axis of each triad, SI; the same for all three axes.
struct NoiseModels {
  NoiseModel accel, gyro;
};

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

/// The noise coefficients of one axis.
struct NoiseCoefficients {
  NoiseCoefficient Q, N, B, K, R;
  std::vector<MarkovTerm> markov;  ///< by falling correlation time
};

/// The contribution of each term to the Allan variance over an averaging time [u^2] (IEEE Std 952); a term that is not determined adds nothing.
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
