// The temperature of a unit on its way, and what its thermal sensors read.
#pragma once

#include "imulab/recording/session.hpp"

#include <vector>

namespace imulab {

/// Straight between the points; before the first and after the last as there. The same throughout the unit; each axis has a sensor of its own (of a
/// ThermalSource: unit, noise, at_25_degC, per_K).
struct UnitTemperature {
  std::vector<double> time, celsius;  // s ascending, degC
  ThermalSource gyro, accel;

  double at(double t) const;  // degC
};

}  // namespace imulab
