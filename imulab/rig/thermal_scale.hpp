// The readings of thermal sensors, as functions of the temperature.
#pragma once

#include "imulab/recording/session.hpp"

#include <string>

namespace imulab::rig {

inline constexpr double room_temperature = 25;  ///< degC: of an IMU whose first step has no set point

/// A reading as a linear function of the temperature.
struct ThermalScale {
  double at_25_degC = 25, per_K = 1;
  double reading(double degC) const { return at_25_degC + per_K * (degC - 25); }
};

/// As a sensor declares it; else degC and K themselves. Throws Error for raw readings without a declaration.
ThermalScale thermal_scale(const ThermalSource& source);
/// Of readings in degC or K.
ThermalScale thermal_scale(const std::string& unit);

}  // namespace imulab::rig

namespace imulab {
using namespace rig;  // until all callers say rig::
}  // namespace imulab
