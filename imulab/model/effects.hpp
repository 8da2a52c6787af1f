// Effects: what a real unit, or its mount, does besides the sensor model. Each adds c phi(state) to the output of the calibrated triads, with c about
// zero under a prior; every method estimates the c beside its coefficients, so that these are as uncertain as such effects make them
// (docs/theory/effects.md).
//
//   EffectState at{.force = f, .rate = w, .gravity = 9.81};
//   const EffectSetting setting{.accel = true, .gyro = true};
//   for (const Effect& e : effects())
//     for (int k = 0; k < e.columns(setting); ++k) by_c.push_back(e.phi(at, k));   // the change of force and rate of c = 1
//
// The even ones are centred on the sphere of attitudes at 1 g: an offset is the mean over attitudes. Those of time are centred on the recording:
// offsets and scales are those of its mean.
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
  double full_force = 9.80665, full_rate = 1;                  ///< m/s^2, rad/s: the largest of the session, not of the instant
  double time = 0;                                             ///< of the recording: -1/2 at its begin, 1/2 at its end
  int recording = 0;                                           ///< of a session's, from 0
  Vector3d play = Vector3d::Zero();                            ///< of the accelerometers' hysteresis: -1 to 1 (PlayOperator)
  Vector3d shaking = Vector3d::Zero();                         ///< (m/s^2)^2: variance of the force beyond the sensor's own noise
  Vector3d stretching = Vector3d::Zero();                      ///< m/s^2 of 1 m at full rate: force that a centrifuge's longer arm adds
  double changed = 0;                                          ///< 1 after a change of the unit, or of its mount
  std::optional<double> warming = {};                          ///< K from the recording's mean; absent: no thermometer
  int machine = 0;                                             ///< of a session's, from 0
  OutputChange by_latitude = {}, by_heading = {};  ///< of what ideal sensors measure, by the latitude, and by the machine's turn about up [1/rad]
  OutputChange by_thermometer = {};                ///< 1/K: what the thermal terms make of an error of the thermometer
  std::array<Vector3d, 2> horizontal{Vector3d::Zero(), Vector3d::Zero()};  ///< unit vectors to north and east, body axes; zero: not known, or turning
};

/// What a session has, on which it depends which effects can be.
struct EffectSetting {
  bool accel = false, gyro = false;  ///< triads that are calibrated
  bool thermometer = false;
  bool mount = false;       ///< the unit is on a table or another machine
  bool changed = false;     ///< it, or its place there, changed at a time
  bool centrifuge = false;  ///< the machine is one
  bool latitude = false;    ///< Earth's rate at a latitude is used
  bool heading = false;     ///< `horizontal` is known
  bool thermal = false;     ///< thermal terms are estimated
  int recordings = 1;
  int machines = 1;  ///< whose heading is used
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
    by_thermal = 512
  };

  std::string_view name;                                      ///< "accel.asymmetry"
  unsigned needs;                                             ///< of the setting: several `Need`
  int basis;                                                  ///< columns; with `by_recordings`, for each recording after the first
  OutputChange (*phi)(const EffectState& state, int column);  ///< of c = 1
  double unit;                                                ///< SI of the unit of c
  std::string_view unit_name;                                 ///< "ppm"
  std::array<double, 4> prior;                                ///< one sigma in that unit: strategic, navigation, tactical, mems
  std::string_view words;                                     ///< of a cause: "the accelerometers' scale differs between the two directions"
  std::string_view advice;                                    ///< the observation that would tell
  /// Of which there is one in each recording, or of each machine, with columns of its own.
  enum class Each { session, recording, machine } each = Each::session;

  /// 0: the setting has not what the effect needs.
  int columns(const EffectSetting& setting) const;
  /// Keys: of [imu], "accel_asymmetry_sigma_ppm", and of [imu.effects], a size to simulate, "accel_asymmetry_ppm".
  std::string_view declared() const;
  std::string_view simulated() const;
  /// A property of the unit: the same in its next calibration.
  bool constant() const { return each == Each::session && (needs & ~(of_accel | of_gyro)) == 0; }
  /// It changes the triad's output, at some state.
  bool changes(Triad triad) const { return (needs & (triad == Triad::accel ? of_accel : of_gyro)) != 0; }
};

/// A column: one c of an effect.
struct EffectColumn {
  const Effect* effect;
  int number;

  OutputChange at(const EffectState& state) const { return effect->phi(state, number); }
};

/// All rows.
std::span<const Effect> effects();
/// Null where there is none of this name.
const Effect* find_effect(std::string_view name);

/// Declared sizes by the name of the effect, one sigma in SI.
using EffectSigmas = std::map<std::string, double, std::less<>>;

/// The grades for which the sizes of effects and terms are stated, the best first.
std::span<const std::string_view> graded_names();
/// One sigma of an effect, SI: as declared, or of a grade.
double effect_sigma(const Effect& effect, const EffectSigmas& declared, std::string_view grade);

/// The accelerometers' hysteresis: a play of width 0.1 g that the force of each axis drags along. `operator()` is given the forces in their order.
class PlayOperator {
 public:
  explicit PlayOperator(double gravity) : half_(0.05 * gravity) {}
  /// Returns each axis's state: -1 dragged downward, +1 upward.
  Vector3d operator()(const Vector3d& force);

 private:
  double half_;
  std::optional<Vector3d> middle_;
};

}  // namespace imulab
