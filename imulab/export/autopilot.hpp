// The common model of PX4 and ArduPilot: parameters in single precision, a diagonal scale for accelerometers alone, offsets with a polynomial of
// temperature.
#pragma once

#include "imulab/export/loss.hpp"

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace imulab::export_io {

/// The thermal drift of a triad's readings as a polynomial of d = T - about, T in degC: c0 + c1 d + c2 d^2 + c3 d^3 (vectors over the axes).
struct CelsiusDrift {
  std::array<double, 2> range;  ///< degC
  double reference;             ///< T0 of the calibration, degC: the drift is zero there
  Vector3d c0, c1, c2, c3;
};
/// Empty where the calibration has no thermal terms, where its thermal readings are no temperatures, and where their range is not known.
std::optional<CelsiusDrift> celsius_drift(const TriadModel& m, double about);

/// The part of this calibration that both hold.
Held autopilot_holds(const SensorModel& model);

/// The largest difference [SI of the readings] over the range between the drift and its polynomial in single precision.
double single_precision_error(const CelsiusDrift& drift, double about);

/// The steepest slope of the drift over its range, in the corrected output: SI for each degree.
double steepest_drift(const CelsiusDrift& drift, double about, const Vector3d& scale);

/// For the head: in which axes the parameters are.
std::vector<std::string> autopilot_axes_facts(const Calibration& calibration);
/// Where accelerometers and gyros were recorded along different axes: an autopilot turns both alike.
void warn_different_axes(std::vector<std::string>& warnings, const Calibration& calibration);

/// "PARAMETER = 3.7: outside 0.8 to 1.2, which PROGRAM accepts"; empty within.
void warn_outside(std::vector<std::string>& warnings, const std::string& parameter, double value, double low, double high, const char* program);

}  // namespace imulab::export_io
