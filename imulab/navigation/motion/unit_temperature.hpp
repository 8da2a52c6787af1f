// The temperature profile of an IMU on a mission, and the readings of its thermal sensors.
#pragma once

#include "imulab/recording/session.hpp"

#include <vector>

namespace imulab::motion {

/// Linear between the points; constant before the first and after the last. The same throughout the unit; each axis has a sensor of its own (of a
/// ThermalSource the unit, noise, reading at 25 degC and scale count).
struct UnitTemperature {
  std::vector<double> time, celsius;  // s ascending, degC
  ThermalSource gyro, accel;

  double at(double t) const;  // degC
};

}  // namespace imulab::motion
