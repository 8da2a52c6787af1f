// The spectrum of a log with vibration beside that of the same axis at rest.
#pragma once

#include "imulab/noise.hpp"

#include <cstddef>
#include <optional>
#include <span>

namespace imulab::noise {

/// A mean over groups of a log with the standard uncertainty of their scatter: vibration need not be stationary.
struct GroupMean {
  double value = 0, sigma = 0, margin = 0;  ///< margin: half of the 95 % interval, by Student's distribution
};

/// Ratios and integrals of the two-sided density S(f) of the moving log and that at rest, Q(f).
struct MovingSpectrum {
  GroupMean floor;                ///< S / Q where the moving log has neither lines nor resonances
  GroupMean vibration;            ///< variance of a reading above `vibration_hz` beyond floor Q [u^2]
  GroupMean derivative;           ///< variance of the derivative of the readings beyond floor Q, from the lowest frequency on [u^2/s^2]
  std::optional<GroupMean> slow;  ///< S / Q below 1 Hz; absent if the pieces are too short
  GroupMean scatter;              ///< variance of a reading above `vibration_hz` relative to that at rest with its lines
  double strongest_hz = 0;        ///< frequency of the largest excess density
};

/// `readings` at intervals `interval_s` [s] are divided into `groups` of equal length. `rest`: noise at rest; Q is its model, or its N^2 without one.
/// Requires groups of at least 16 readings.
MovingSpectrum moving_spectrum(std::span<const double> readings, double interval_s, const NoiseFit& rest, double vibration_hz, std::size_t groups);

/// Raises the densities that a log at rest permits to the upper bounds of a log in motion, each a mean over the frequencies nearer to it than to its
/// neighbors, and returns true if any was raised. A density is raised only if it explains the log in motion with a probability below 0.1 %: a short
/// log excludes little, and where it does not contradict the one at rest, that one counts. `rest`: its quantization is not part of the densities.
bool raise_to_motion(std::vector<UpperDensity>& upper, std::span<const double> readings, double interval_s, const NoiseFit& rest, double lowest_hz,
                     double confidence);

}  // namespace imulab::noise
