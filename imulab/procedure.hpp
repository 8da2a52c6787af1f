// Standard procedures: sessions without recordings, as input for editing, prediction and simulation.
//
// Example:
//   Session zhang = zhang_24_procedure({.rest = 60, .table = 2 * unit::arcsec, .grade = "navigation"});
//   zhang.steps.back().end += 30;  // s: a longer last rest
//   const Prediction prediction = predict("turntable", zhang);
//
// Angles are in rad, by RigAxis (outer, middle, inner); times are in s. Functions throw Error if the numbers are invalid. Safe on any thread.
#pragma once

#include "imulab/session.hpp"
#include "imulab/units.hpp"

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

struct HandHeldOptions {
  int poses = 40;          ///< number of rests, each at a different attitude
  double first_rest = 30;  ///< [s]; the longest rest, which determines the noise
  double rest = 4;         ///< s
  double move = 2;         ///< move between rests [s]
  double rate_hz = 100;
  double latitude = 45 * unit::deg;
  double height = 0;  ///< m
  std::string grade = "mems";
};

/// An IMU that warms up from a cold soak while it is turned by hand: 95 % of the way to the room's temperature, exponentially.
struct WarmUpOptions {
  double from = -15, to = 25;  ///< degC: of the freezer and of the room
  double minutes = 20;
  HandHeldOptions by_hand{.first_rest = 15, .rest = 10, .move = 3};  ///< poses follow from the time
};
Session warm_up_procedure(const WarmUpOptions& options, std::uint64_t seed);

/// Returns a procedure for an IMU turned by hand: rests at random attitudes (uniform gravity directions and headings, drawn by `seed`) and moves.
Session hand_held_procedure(const HandHeldOptions& options, std::uint64_t seed);

struct TableProcedureOptions {
  double rest = 60;                   ///< each rest [s]
  double move = 10;                   ///< [s], from one position to the next if no turn is commanded
  double turn_rate = 10 * unit::deg;  ///< rad/s
  int turns = 5;                      ///< zhang-24, two-axis: number of turns each way about each axis
  double table = 2 * unit::arcsec;    ///< declared sigma of angles, orthogonality and zero [rad]
  double rate_hz = 100;
  double latitude = 45 * unit::deg;
  double height = 0;  ///< m
  std::string grade = "navigation";
};

/// Points each body axis up and down once, by the middle and inner axes of a turntable.
Session six_position_procedure(const TableProcedureOptions& options);

/// Ferraris 1995, by hand: a box with the IMU is put on each of its six faces, and turned by 360 deg about each vertical axis. The rig is a turntable
/// with the accuracy of a hand; `ferraris_options` returns options for turns by hand and a MEMS unit.
Session ferraris_procedure(const TableProcedureOptions& options);
TableProcedureOptions ferraris_options();

/// Zhang 2010: turns forward and back about each axis, then 24 positions: each body axis up and down by the inner and middle axes, each at four
/// headings of the outer axis. In Zhang's frame (x north, y up, z east), the faces are x, y, z up, then x, y, z down.
Session zhang_24_procedure(const TableProcedureOptions& options);

/// A turn about one axis of a table and the rest after it.
struct TableTurn {
  RigAxis axis;
  double angle_deg;
  double rest;  ///< s
};
/// Uses two axes of a table, middle and inner: turns forward and back about each body axis, then the 16 positions of quarter turns.
Session two_axis_procedure(const TableProcedureOptions& options);

/// Returns turns between rests for the IMU `name`; the first rest lasts `first_rest` [s]. `options.rest` and `options.turns` are ignored.
Session turns_procedure(const std::string& name, double first_rest, std::span<const TableTurn> turns, const TableProcedureOptions& options);

/// A path after Cheng 2014: 20 turns of 90 and 180 deg with rests between them, which make every coefficient observable.
Session cheng_path_procedure(const TableProcedureOptions& options);

/// The table procedures that need only options.
struct TableProcedure {
  std::string_view name, summary;
  Session (*make)(const TableProcedureOptions& options);
  TableProcedureOptions options;  ///< default options
};
const std::vector<TableProcedure>& table_procedures();  ///< returns all of them

/// Source of the thermal readings: a sensor at each axis of a triad, one sensor per triad, or the gyros' resonance frequencies with three sensors at
/// the accelerometers.
enum class ThermalSensors { three, one, resonance };
std::string_view to_string(ThermalSensors sensors);

struct DaiUnitOptions {
  double record = 10;  ///< duration of each point [s]
  double rate_hz = 50;
  ThermalSensors thermal = ThermalSensors::three;
  bool both_ways = false;  ///< cools the chamber again after heating
  std::vector<RigKind> machines{RigKind::chamber, RigKind::rate_table, RigKind::centrifuge};
  double latitude = 45 * unit::deg;
  double height = 0;  ///< m
  std::string grade = "mems-30g";
};

/// Dai 2011 section 3: an IMU in a thermal chamber (15 points), on a rate table (each face up, 41 rates) and on a centrifuge (each face outward,
/// seven accelerations). Each machine has one recording, which contains only its steps. Throws Error if `machines` is empty.
Session dai_unit_procedure(const DaiUnitOptions& options);

}  // namespace imulab
