#include "imulab/navigation/unit_temperature.hpp"

#include "imulab/core/error.hpp"

#include <algorithm>

namespace imulab {

double TemperatureCourse::at(double t) const {
  const auto after = std::upper_bound(time.begin(), time.end(), t);
  if (after == time.begin()) return celsius.front();
  if (after == time.end()) return celsius.back();
  const auto i = static_cast<std::size_t>(after - time.begin());
  const double part = (t - time[i - 1]) / (time[i] - time[i - 1]);
  return (1 - part) * celsius[i - 1] + part * celsius[i];
}

double thermal_reading(const ThermalSource& source, double celsius) {
  constexpr double room = 25, kelvin = 273.15;
  if (source.unit == "raw" && !(source.at_25_degC && source.per_K))
    throw Error("a thermal reading in raw units: at_25_degC and per_K were expected");
  const double at_room = source.unit == "K" ? room + kelvin : room;
  return source.at_25_degC.value_or(at_room) + source.per_K.value_or(1) * (celsius - room);
}

}  // namespace imulab
