// Effects: errors of a real unit or its mount beyond the sensor model. Each adds c phi(state) to the output of the calibrated triads, with a
// zero-mean prior of c. Every method estimates c jointly with its coefficients, so that their uncertainty includes such effects
// (docs/theory/effects.md).
//
//   EffectState at{.force = f, .rate = w, .gravity = 9.81};
//   const EffectSetting setting{.accel = true, .gyro = true};
//   for (const Effect& e : effects())
//     for (int k = 0; k < e.columns(setting); ++k) by_c.push_back(e.phi(at, k));   // the change of force and rate of c = 1
//
// Even effects are centered on the sphere of attitudes at 1 g: an offset is the mean over attitudes. Effects of time are centered on the recording:
// offsets and scales are means over it.
#pragma once

#include "imulab/coefficient.hpp"
#include "imulab/eigen.hpp"

#include <array>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

/// A change of the triads' outputs, m/s^2 and rad/s.
struct OutputChange {
  Vector3d force = Vector3d::Zero(), rate = Vector3d::Zero();
};

/// The state of a unit at an instant, or its mean over an observation.
struct EffectState {
  Vector3d force = Vector3d::Zero(), rate = Vector3d::Zero();  ///< m/s^2, rad/s: specific force, angular rate, body axes
  double gravity = 9.80665;                                    ///< m/s^2, local
  double full_force = 9.80665, full_rate = 1;                  ///< m/s^2, rad/s: largest of the session, not of the instant
  double time = 0;                                             ///< relative to the recording: -1/2 at its begin, 1/2 at its end
  int recording = 0;                                           ///< index in the session, from 0
  Vector3d play = Vector3d::Zero();                            ///< state of the accelerometers' hysteresis: -1 to 1 (PlayOperator)
  Vector3d shaking = Vector3d::Zero();                         ///< (m/s^2)^2: variance of the force beyond the sensor's own noise
  Vector3d stretching = Vector3d::Zero();                      ///< m/s^2 per 1 m at full rate: additional force due to a longer arm of a centrifuge
  double changed = 0;                                          ///< 1 after a change of the unit or its mount
  std::optional<double> warming = {};                          ///< K relative to the mean of the recording; absent: no thermometer
  double warming_rate = 0;                                     ///< K/s, smoothed; 0 unless the temperature sweeps
  int machine = 0;                                             ///< index in the session, from 0
  OutputChange by_latitude = {}, by_heading = {};  ///< change of ideal readings by the latitude, and by the machine's rotation about up [1/rad]
  OutputChange by_thermometer = {};                ///< 1/K: effect of a thermometer error through the thermal terms
  std::array<Vector3d, 2> horizontal{Vector3d::Zero(), Vector3d::Zero()};  ///< unit vectors north and east, body axes; zero: unknown, or turning
};

/// The properties of a session that determine which effects can occur.
struct EffectSetting {
  bool accel = false, gyro = false;  ///< triads that are calibrated
  bool thermometer = false;
  bool mount = false;       ///< the unit is on a table or another machine
  bool changed = false;     ///< the unit or its mounting changed at a known time
  bool centrifuge = false;  ///< the machine is a centrifuge
  bool latitude = false;    ///< the Earth's rate at a latitude is used
  bool heading = false;     ///< `horizontal` is known
  bool thermal = false;     ///< thermal terms are estimated
  bool sweep = false;       ///< the temperature changes so much that the thermal terms are estimated as effects
  int recordings = 1;
  int machines = 1;  ///< number of machines with a used heading
};

/// A row of the table.
struct Effect {
  enum Need : unsigned {
    of_accel = 1,
    of_gyro = 2,
    by_thermometer = 4,
    by_recordings = 8,
    by_mount = 16,
    by_centrifuge = 32,
    by_latitude = 64,
    by_change = 128,
    by_north = 256,
    by_thermal = 512,
    by_sweep = 1024
  };

  std::string_view name;                                      ///< "accel.asymmetry"
  unsigned needs;                                             ///< combination of `Need`
  int basis;                                                  ///< number of columns; with `by_recordings`, for each recording after the first
  OutputChange (*phi)(const EffectState& state, int column);  ///< change for c = 1
  double unit;                                                ///< SI value of the unit of c
  std::string_view unit_name;                                 ///< "ppm"
  std::array<double, 4> prior;                                ///< one sigma in that unit: strategic, navigation, tactical, mems
  std::string_view words;                                     ///< text of a cause: "the accelerometers' scale differs between the two directions"
  std::string_view advice;                                    ///< the observation that would determine it
  /// Whether each recording, or each machine, has columns of its own.
  enum class Each { session, recording, machine } each = Each::session;

  /// Returns the number of columns; 0 if the setting lacks something that the effect needs.
  int columns(const EffectSetting& setting) const;
  /// Return keys: of a declared sigma in [imu], "accel_asymmetry_sigma_ppm", and of a simulated size in [imu.effects], "accel_asymmetry_ppm".
  std::string_view declared() const;
  std::string_view simulated() const;
  /// Returns true for a property of the unit, which recurs in its next calibration.
  bool constant() const { return each == Each::session && (needs & ~(of_accel | of_gyro)) == 0; }
  /// Returns true if the effect changes the triad's output in some state.
  bool changes(Triad triad) const { return (needs & (triad == Triad::accel ? of_accel : of_gyro)) != 0; }
};

/// A column: one c of an effect.
struct EffectColumn {
  const Effect* effect;
  int number;

  OutputChange at(const EffectState& state) const { return effect->phi(state, number); }
};

// The thermal terms have one size: the second order is as large as the first at 50 K from the mean, and the thermometer is up to 30 s late (one
// sigma).
inline constexpr double second_order_per_first = 50, thermometer_lag_s = 30;

/// A column of an effect matrix_thermal: an element of M1 or M2, or of their lags.
struct MatrixThermal {
  int row, column, order;
  bool lags;
  /// Misalignments change a tenth as much as scales.
  double size() const { return row == column ? 1 : 0.1; }
};
/// Accelerometers have a lower triangle, since rests do not show a rotation.
inline MatrixThermal matrix_thermal(Triad triad, int column) {
  constexpr std::array<std::array<int, 2>, 9> elements{{{0, 0}, {1, 1}, {2, 2}, {1, 0}, {2, 0}, {2, 1}, {0, 1}, {0, 2}, {1, 2}}};
  const int count = triad == Triad::accel ? 6 : 9;
  const auto& [row, input] = elements[static_cast<std::size_t>(column % count)];
  return {row, input, 1 + (column / count) % 2, column / count >= 2};
}

/// Returns all effects.
std::span<const Effect> effects();
/// Returns the effect with this name, or null.
const Effect* find_effect(std::string_view name);

/// Declared sizes by the name of the effect, one sigma in SI.
using EffectSigmas = std::map<std::string, double, std::less<>>;

/// Returns the grades for which sizes of effects and terms are given, the best first.
std::span<const std::string_view> graded_names();
/// Returns one sigma of an effect, SI: declared, or from a grade.
double effect_sigma(const Effect& effect, const EffectSigmas& declared, std::string_view grade);

/// The accelerometers' hysteresis: a play of width 0.1 g that follows the force of each axis. `operator()` receives the forces in their order.
class PlayOperator {
 public:
  explicit PlayOperator(double gravity) : half_(0.05 * gravity) {}
  /// Returns the state of each axis: -1 moved downward, +1 upward.
  Vector3d operator()(const Vector3d& force);

 private:
  double half_;
  std::optional<Vector3d> middle_;
};

}  // namespace imulab
