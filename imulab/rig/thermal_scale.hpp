// The readings of thermal sensors, as functions of the temperature.
//
//   thermal_scale("K").reading(25)   // 298.15
#pragma once

#include "imulab/recording.hpp"
#include "imulab/session.hpp"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace imulab {

inline constexpr double room_temperature = 25;  ///< degC: of an IMU whose first step has no set point

/// A reading as a linear function of the temperature.
struct ThermalScale {
  double at_25_degC = 25, per_K = 1;
  double reading(double degC) const { return at_25_degC + per_K * (degC - 25); }
};

/// As a sensor declares it; else degC and K themselves. Throws Error for raw readings without a declaration.
ThermalScale thermal_scale(const ThermalSource& source);
/// The scale of readings in degC or K.
ThermalScale thermal_scale(const std::string& unit);

/// The first thermal sensor of a recording, which must outlive it, whose readings say something in K.
struct Thermometer {
  const std::vector<double>* readings;
  std::string unit;
  double per_K, mean;                                                                        ///< of the readings
  double warming(std::size_t sample) const { return ((*readings)[sample] - mean) / per_K; }  ///< K from the recording's mean
};
std::optional<Thermometer> thermometer_of(const Recording& recording, const RecordingSource& source);

}  // namespace imulab
