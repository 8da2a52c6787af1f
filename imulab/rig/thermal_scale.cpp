#include "imulab/rig/thermal_scale.hpp"

#include "imulab/error.hpp"

#include <numeric>

namespace imulab {

ThermalScale thermal_scale(const std::string& unit) { return {unit == "K" ? 298.15 : 25, 1}; }

ThermalScale thermal_scale(const ThermalSource& source) {
  if (source.at_25_degC && source.per_K) return {*source.at_25_degC, *source.per_K};
  if (source.unit == "raw")
    throw Error("a thermal reading in \"raw\"; expected its value at 25 degC and its change per K, or a reading in degC or K");
  return thermal_scale(source.unit);
}

std::optional<Thermometer> thermometer_of(const Recording& recording, const RecordingSource& source) {
  for (const bool of_gyros : {false, true}) {
    const std::vector<double>& readings = (of_gyros ? recording.gyro_temperature : recording.accel_temperature)[0];
    const std::optional<ThermalSource>& sensor = of_gyros ? source.gyro_temperature : source.accel_temperature;
    if (readings.empty() || !sensor || (sensor->unit == "raw" && !sensor->per_K)) continue;
    const double mean = std::accumulate(readings.begin(), readings.end(), 0.0) / static_cast<double>(readings.size());
    return Thermometer{&readings, sensor->unit, thermal_scale(*sensor).per_K, mean};
  }
  return {};
}

}  // namespace imulab
