#include "imulab/navigation/motion/unit_temperature.hpp"

#include <algorithm>

namespace imulab::motion {

double UnitTemperature::at(double t) const {
  const auto after = std::upper_bound(time.begin(), time.end(), t);
  if (after == time.begin()) return celsius.front();
  if (after == time.end()) return celsius.back();
  const auto i = static_cast<std::size_t>(after - time.begin());
  const double part = (t - time[i - 1]) / (time[i] - time[i - 1]);
  return (1 - part) * celsius[i - 1] + part * celsius[i];
}

}  // namespace imulab::motion
