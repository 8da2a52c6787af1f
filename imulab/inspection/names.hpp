// The name of a column is a hint, which the data have to confirm.
#pragma once

#include "imulab/inspection/signals.hpp"
#include "imulab/session.hpp"

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

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

/// The hint of a column in its table. Where its name gives an axis alone, as in "x (rad/s)", its unit says which sensor it is of, or else the name of
/// its file or topic: "Gyroscope.csv".
NameHint hint_in(const SignalTable& table, std::size_t column);

/// A unit as files write it, as a session names it: "m/s2" and "mps2" are "m/s^2", "dps" is "deg/s"; empty where it is none.
std::string unit_of(std::string_view text);

/// A unit that readings may have, and what speaks for it.
struct UnitGuess {
  std::string unit = "count";
  Output output = Output::rate;
  std::string evidence;
  Question open;  ///< where several units fit or none
};

/// `norm`: of the readings at rest, which is `interval_s` g where they are increments. `named`: the unit that the file or the column's name states;
/// may be empty. `whole`: the readings are whole numbers.
UnitGuess accel_unit(double norm, double least, double most, double interval_s, const std::string& named, bool whole);

/// `scale`: rad/s per reading, by the turns.
UnitGuess gyro_unit(double scale, double interval_s, const std::string& named, bool whole);

/// The scales that gyros can have: of every unit, as rates and as increments.
std::vector<double> gyro_scales(double interval_s);

}  // namespace imulab::inspection
