// What the name of a column says: a hint, which the data have to confirm.
#pragma once

#include <string>
#include <string_view>

namespace imulab::inspection {

enum class Role { unknown, time, fraction, sample_number, gyro, accel, temperature, other };

struct NameHint {
  Role role = Role::unknown;
  int axis = -1;        ///< 0 x, 1 y, 2 z; -1 unknown
  std::string unit;     ///< as a session names it; empty where the name has none
  std::string unknown;  ///< a unit in brackets that is none known here
  std::string sensor;   ///< the name without its axis and unit: columns of one triad share it
  bool ticks = false;   ///< a counter of unknown ticks
};

/// "acc_x [m/s^2]", "GyroY(dps)", "angular_velocity.z", "wx", "timestamp_us", "Temp": role, axis and unit. `Role::other` is what is known not to be
/// wanted: magnetometers, orientations, positions, pressure.
NameHint hint_of(std::string_view name);

/// A unit as files write it, as a session names it: "m/s2" and "mps2" are "m/s^2", "dps" is "deg/s"; empty where it is none.
std::string unit_of(std::string_view text);

}  // namespace imulab::inspection
