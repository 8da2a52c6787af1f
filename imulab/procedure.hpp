// Standard procedures: sessions without recordings, ready to edit, to predict and to simulate.
//
// Example:
//   Session zhang = zhang_24_procedure({.rest = 60, .table = 2 * unit::arcsec, .grade = "navigation"});
//   zhang.steps.back().end += 30;  // s: a longer last rest
//   const Prediction prediction = predict("turntable", zhang);
//
// Angles in rad by RigAxis (outer, middle, inner), times in s. Throw Error for numbers that make no procedure. Safe on any thread.
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
  int poses = 40;          ///< rests, each at an attitude of its own
  double first_rest = 30;  ///< s; the longest: it shows the noise
  double rest = 4;         ///< s
  double move = 2;         ///< s, from rest to rest
  double rate_hz = 100;
  double latitude = 45 * unit::deg;
  double height = 0;  ///< m
  std::string grade = "mems";
};

/// An IMU turned by hand: rests at random attitudes (directions of gravity and headings uniform) with moves between them.
Session hand_held_procedure(const HandHeldOptions& options, std::uint64_t seed);

struct TableProcedureOptions {
  double rest = 60;                   ///< s, each
  double move = 10;                   ///< s, from one position to the next where no turn is commanded
  double turn_rate = 10 * unit::deg;  ///< rad/s
  int turns = 5;                      ///< zhang-24, two-axis: each way about each axis
  double table = 2 * unit::arcsec;    ///< rad: declared sigma of angles, orthogonality and zero
  double rate_hz = 100;
  double latitude = 45 * unit::deg;
  double height = 0;  ///< m
  std::string grade = "navigation";
};

/// Each body axis up and down once, by the middle and inner axes of a turntable.
Session six_position_procedure(const TableProcedureOptions& options);

/// Ferraris 1995, by hand: a box with the IMU is put on each of its six faces, and turned by 360 deg about each axis while that is up. The rig is a
/// turntable of a hand's accuracy; for a hand, of MEMS grade: `ferraris_options`.
Session ferraris_procedure(const TableProcedureOptions& options);
TableProcedureOptions ferraris_options();

/// Zhang 2010: turns forward and back about each axis, then 24 positions: each body axis up and down by the inner and middle axes, at each
/// four headings by the outer. In his frame (x north, y up, z east) the faces are x, y, z up, then x, y, z down.
Session zhang_24_procedure(const TableProcedureOptions& options);

/// A turn about one axis of a table, and the rest after it.
struct TableTurn {
  RigAxis axis;
  double angle_deg;
  double rest;  ///< s
};
/// With two axes of a table, middle and inner: turns forward and back about each body axis, then the 16 positions of quarter turns.
Session two_axis_procedure(const TableProcedureOptions& options);

/// Turns between rests, the first of which lasts `first_rest` s; `options.rest` and `options.turns` are ignored.
Session turns_procedure(const std::string& name, double first_rest, std::span<const TableTurn> turns, const TableProcedureOptions& options);

/// A path after Cheng 2014: 20 turns of 90 and 180 deg with rests between them, so that every coefficient is observable.
Session cheng_path_procedure(const TableProcedureOptions& options);

/// The procedures on a table that are made by options alone, in one table.
struct TableProcedure {
  std::string_view name, summary;
  Session (*make)(const TableProcedureOptions& options);
  TableProcedureOptions options;  ///< unless others are given
};
const std::vector<TableProcedure>& table_procedures();

/// The source of the thermal readings: a sensor at each axis of a triad, one at each triad, or the gyros' resonance frequencies and three sensors at
/// the accelerometers.
enum class ThermalSensors { three, one, resonance };
std::string_view to_string(ThermalSensors sensors);

struct DaiUnitOptions {
  double record = 10;  ///< s, of each point
  double rate_hz = 50;
  ThermalSensors thermal = ThermalSensors::three;
  bool both_ways = false;  ///< the chamber cools again
  std::vector<RigKind> machines{RigKind::chamber, RigKind::rate_table, RigKind::centrifuge};
  double latitude = 45 * unit::deg;
  double height = 0;  ///< m
  std::string grade = "mems-30g";
};

/// Dai 2011 section 3: an IMU in a thermal chamber (15 points), on a rate table (each face up, 41 rates) and on a centrifuge (each face
/// outward, seven accelerations), each a recording of its steps alone; with the machines named. Throws Error for none of them.
Session dai_unit_procedure(const DaiUnitOptions& options);

}  // namespace imulab
