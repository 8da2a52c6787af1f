// A specification of inertial errors as in a data sheet, fixed or one sigma. Missing terms come from a grade, an airliner's system or a calibration.
#pragma once

#include "imulab/navigate.hpp"
#include "imulab/navigation/budget/budget.hpp"

#include <optional>
#include <string>

namespace imulab {

struct Calibration;

/// Terms of one triad, SI; absent: from the grade, or zero.
struct TriadErrors {
  std::optional<Spread> bias;              ///< each axis
  std::optional<Spread> scale;             ///< each axis, relative
  std::optional<Spread> misalignment;      ///< all six elements [rad]
  std::optional<Spread> nonorthogonality;  ///< the three below the diagonal [rad], instead of `misalignment`: axes relative to the triad itself
  std::optional<Spread> quadratic;         ///< each axis, out/in^2
  std::optional<Spread> g_sensitivity;     ///< gyros: all nine elements [(rad/s)/(m/s^2)]
  std::optional<Spread> turn_on, R;        ///< these and the following as in NoiseModel
  std::optional<double> N, B, K, Q;
};

struct ErrorSpecification {
  std::optional<std::string> grade, system, calibration;  ///< at most one of them; `calibration` is a file name
  std::optional<std::string> noise;                       ///< file of a noise analysis: its terms replace missing ones
  TriadErrors gyro, accel;
  StartErrors start;
  BarometerErrors barometer;
  VerticalChannel vertical = VerticalChannel::free;
};

/// Returns the sources for the budget and the Monte Carlo. `calibration` is the one that the specification names; coefficients without a covariance
/// are exact. Throws Error for contradictory terms, and for an unknown grade or system.
ErrorSources error_sources(const ErrorSpecification& specification, const Calibration* calibration = nullptr);

}  // namespace imulab
