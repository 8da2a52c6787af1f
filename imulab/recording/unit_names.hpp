// The units that readings and stamps may have, in one table.
#pragma once

#include <string_view>
#include <vector>

namespace imulab {

enum class Quantity { gyro, accel, temperature, time };

/// Names of the units of a quantity: "rad/s" among those of rates, "rad" among those of increments (sums over an interval), "count" among both.
std::vector<std::string_view> unit_names(Quantity quantity, bool increment);

/// The name in this list of the unit that `text` spells: "deg/s" for "dps" and "°/s". Empty: there is none.
std::string_view unit_name(std::string_view text, Quantity quantity, bool increment);

/// The factor that brings a gyro's or accelerometer's unit to SI: 1 for count.
double si_factor(std::string_view unit);

/// A unit of time as nanoseconds, as a power of ten: 9 for s.
int time_exponent(std::string_view unit);

}  // namespace imulab
