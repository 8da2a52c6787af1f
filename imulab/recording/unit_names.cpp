#include "imulab/recording/unit_names.hpp"

#include "imulab/core/unit_expression.hpp"
#include "imulab/units.hpp"

#include <algorithm>
#include <array>

namespace imulab {
namespace {

enum class Of { any, rate, increment };

struct Unit {
  std::string_view name;
  Quantity quantity;
  Of output;
  double factor;  // to SI; thermal readings are not converted, times are converted exactly by time_exponent
};

constexpr std::array units{
    Unit{"count", Quantity::gyro, Of::any, 1},
    Unit{"rad/s", Quantity::gyro, Of::rate, 1},
    Unit{"deg/s", Quantity::gyro, Of::rate, unit::deg},
    Unit{"mdeg/s", Quantity::gyro, Of::rate, 1e-3 * unit::deg},
    Unit{"deg/min", Quantity::gyro, Of::rate, unit::deg / 60},
    Unit{"deg/h", Quantity::gyro, Of::rate, unit::deg_per_h},
    Unit{"rad", Quantity::gyro, Of::increment, 1},
    Unit{"deg", Quantity::gyro, Of::increment, unit::deg},
    Unit{"arcsec", Quantity::gyro, Of::increment, unit::arcsec},
    Unit{"count", Quantity::accel, Of::any, 1},
    Unit{"m/s^2", Quantity::accel, Of::rate, 1},
    Unit{"g", Quantity::accel, Of::rate, unit::g},
    Unit{"mg", Quantity::accel, Of::rate, 1e-3 * unit::g},
    Unit{"ug", Quantity::accel, Of::rate, unit::ug},
    Unit{"m/s", Quantity::accel, Of::increment, 1},
    Unit{"g*s", Quantity::accel, Of::increment, unit::g},
    Unit{"degC", Quantity::temperature, Of::any, 1},
    Unit{"K", Quantity::temperature, Of::any, 1},
    Unit{"raw", Quantity::temperature, Of::any, 1},
    Unit{"s", Quantity::time, Of::any, 1},
    Unit{"ms", Quantity::time, Of::any, 1},
    Unit{"us", Quantity::time, Of::any, 1},
    Unit{"ns", Quantity::time, Of::any, 1},
};

}  // namespace

std::vector<std::string_view> unit_names(Quantity quantity, bool increment) {
  std::vector<std::string_view> names;
  for (const Unit& u : units)
    if (u.quantity == quantity && u.output != (increment ? Of::rate : Of::increment)) names.push_back(u.name);
  return names;
}

std::string_view unit_name(std::string_view text, Quantity quantity, bool increment) {
  const std::vector<std::string_view> names = unit_names(quantity, increment);
  auto found = std::find(names.begin(), names.end(), text);
  if (found == names.end()) found = std::find_if(names.begin(), names.end(), [&](std::string_view name) { return is_same_unit(text, name); });
  return found == names.end() ? std::string_view() : *found;
}

double si_factor(std::string_view name) {
  const auto found = std::find_if(units.begin(), units.end(), [&](const Unit& u) { return u.name == name; });
  return found == units.end() ? 1 : found->factor;
}

int time_exponent(std::string_view unit) { return unit == "s" ? 9 : unit == "ms" ? 6 : unit == "us" ? 3 : 0; }

}  // namespace imulab
