// A specification of inertial errors as in a data sheet: term by term, each fixed or one sigma; terms that are not given come from a grade, an
// airliner's system or a calibration.
#pragma once

#include "imulab/navigate.hpp"
#include "imulab/navigation/budget/budget.hpp"

#include <optional>
#include <string>

namespace imulab {

struct Calibration;

/// Terms of one triad, SI; absent: as the grade has them, or none.
struct TriadErrors {
  std::optional<Spread> bias;              ///< each axis
  std::optional<Spread> scale;             ///< each axis, relative
  std::optional<Spread> misalignment;      ///< all six elements [rad]
  std::optional<Spread> nonorthogonality;  ///< the three below the diagonal [rad], in place of `misalignment`: axes referred to the triad itself
  std::optional<Spread> quadratic;         ///< each axis, out/in^2
  std::optional<Spread> g_sensitivity;     ///< gyros: all nine elements [(rad/s)/(m/s^2)]
  std::optional<Spread> turn_on, R;        ///< as in NoiseModel, and the following
  std::optional<double> N, B, K, Q;
};

struct ErrorSpecification {
  std::optional<std::string> grade, system, calibration;  ///< one of them at most; `calibration` names its file
  std::optional<std::string> noise;                       ///< file of an analysis: its terms where none is given
  TriadErrors gyro, accel;
  StartErrors start;
  BarometerErrors barometer;
  VerticalChannel vertical = VerticalChannel::free;
};

/// The sources for the budget and the Monte Carlo. `calibration`: the one that the specification names; coefficients without a covariance are exact.
/// Throws Error for terms that contradict each other, and for an unknown grade or system.
ErrorSources error_sources(const ErrorSpecification& specification, const Calibration* calibration = nullptr);

}  // namespace imulab
