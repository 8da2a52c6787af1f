// Errors of a triad's readings that are not in the sensor model: noise terms with the names of IEEE Std 952, and the limits of its output.
#pragma once

#include "imulab/core/spread.hpp"

namespace imulab {

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

/// Of one axis of each triad, SI; the same for all three axes.
struct NoiseModels {
  NoiseModel accel, gyro;
};

}  // namespace imulab
