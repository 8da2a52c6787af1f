#include "imulab/rig/thermal_scale.hpp"

#include "imulab/error.hpp"

namespace imulab {

ThermalScale thermal_scale(const std::string& unit) { return {unit == "K" ? 298.15 : 25, 1}; }

ThermalScale thermal_scale(const ThermalSource& source) {
  if (source.at_25_degC && source.per_K) return {*source.at_25_degC, *source.per_K};
  if (source.unit == "raw")
    throw Error("a thermal reading in \"raw\"; expected its value at 25 degC and its change per K, or a reading in degC or K");
  return thermal_scale(source.unit);
}

}  // namespace imulab
