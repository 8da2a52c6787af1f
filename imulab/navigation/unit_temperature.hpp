// The temperature of a unit on its way, and what its sensors of temperature read.
#pragma once

#include "imulab/recording/session.hpp"

#include <vector>

namespace imulab {

/// Straight between the points; before the first and after the last as there.
struct TemperatureCourse {
  std::vector<double> time, celsius;  // s ascending, degC

  double at(double t) const;
};

/// The same temperature throughout the unit; each axis has a sensor of its own (of a ThermalSource: unit, noise, at_25_degC, per_K).
struct UnitTemperature {
  TemperatureCourse course;
  ThermalSource gyro, accel;
};

/// Without noise, in the source's unit. `Error` for a raw one that does not say what it reads.
double thermal_reading(const ThermalSource& source, double celsius);

}  // namespace imulab
