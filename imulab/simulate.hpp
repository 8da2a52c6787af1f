// Simulates a recording from true motion, a true IMU and noise. It works on values in memory; the command, tests and Monte Carlo runs use the same
// call.
//
// Example:
//   const Session procedure = dai_unit_procedure({});
//   const Truth truth = draw_truth(procedure, 1);
//   const RecordingSource& source = procedure.recordings.front();
//   const Recording simulated = simulate_recording(procedure, source, truth, 1, draw_rig_errors(procedure, source, 1));
//
// The error sources of a rig are one list:
// - orthogonality: l_outer = (o1, o2, 1), l_middle = (m1, 1, m2), l_inner = (1, i1, i2) in n at zero angles, then normalized;
// - zero: a constant angle error of each axis (outer: relative to north; middle and inner: leveling error of the IMU at zero angles);
// - tilt: a tilt of the whole table about east and about north;
// - angle: angle error at a stop; each axis draws one at the start, and a new one only when it is commanded to move;
// - timing: time by which a commanded rotation lasts longer; it still ends at its angle;
// - mount, rate, radius: errors of rate table and centrifuge.
// A table with fewer axes is a table of which the procedure does not use all axes. An axis that remains at zero has neither orthogonality nor angle
// errors; its zero error remains because it represents the mounting of the IMU.
//
// A draw depends only on the seed and the drawn quantity: equal seeds give bit-identical results for any number of threads. Values are SI. Functions
// throw Error if a procedure lacks a latitude, noise or a spread. The time is linear in the number of samples. Safe on any thread.
#pragma once

#include "imulab/grade.hpp"
#include "imulab/recording.hpp"
#include "imulab/sensor_model.hpp"
#include "imulab/session.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace imulab {

enum class RigErrorKind { orthogonality, zero, tilt, angle, timing, mount, rate, radius };

struct RigErrorSource {
  static constexpr std::size_t at_start = static_cast<std::size_t>(-1);

  RigErrorKind kind = RigErrorKind::zero;
  std::size_t axis = 0;         ///< RigAxis index; for a tilt: 0 about east, 1 about north; for a mount: body axis of the rotation
  std::size_t element = 0;      ///< element of an orthogonality: 0 or 1, as in i1, i2
  std::size_t step = at_start;  ///< angle or timing error: index of the step (of its recording) that draws it
  Mount place{};                ///< mount to which a mount or radius error belongs
  double known = 0;             ///< declared value [rad, s, m or relative], the mean of the draws
  double sigma = 0;             ///< standard deviation of the draw, same unit; 0 if known exactly

  /// Returns "orthogonality.inner.1", "zero.outer", "tilt.east", "angle.middle.start", "angle.middle.12", "timing.3" (steps count from 1), or for
  /// machines "rate", "mount.+z+x.y", "radius.+z+x".
  std::string name() const;
  bool operator==(const RigErrorSource&) const = default;
};

/// Returns every declared error source of a recording's rig: first those of the table or machine, then by step or mount. The list is empty for kind
/// none (turns by hand).
std::vector<RigErrorSource> rig_error_sources(const Session& session, const RecordingSource& source);

/// Error sources and their values. Empty lists mean a rig without errors.
struct RigErrors {
  std::vector<RigErrorSource> sources = {};
  std::vector<double> values = {};  ///< rad, s, m or relative
};

/// Draws the errors of the rig of `source` with `seed`. Recordings on one rig share its table errors; angle and timing errors are separate.
RigErrors draw_rig_errors(const Session& session, const RecordingSource& source, std::uint64_t seed);

/// The exact size of an effect beyond the sensor model (docs/theory/effects.md).
struct EffectValue {
  std::string name = {};  ///< "accel.asymmetry"
  int column = 0;         ///< column index, if the effect has several
  double value = 0;       ///< SI
};

/// The exact values of a simulation, which a calibration should recover.
struct Truth {
  SensorModel model;
  double gravity = 0;                           ///< m/s^2
  std::optional<double> latitude{};             ///< rad; absent: latitude of the site
  BodyFrame frame = BodyFrame::accelerometers;  ///< frame of the model
  NoiseModel accel_noise{}, gyro_noise{};       ///< errors that are not coefficients of the model; one recording does not determine them
  std::vector<EffectValue> effects{};           ///< values of [imu.effects]
};

/// Draws the IMU from imu.grade (or uses `given`), and gravity and latitude from the site's values and sigmas; `seed` determines all draws. Declared
/// noise replaces the grade's, of which only white noise is used unless imu.noise requests all terms. The frame is the accelerometers' (lower
/// triangular accelerometer matrix), or the rig's for a grade with ranges. Thermal terms match the recordings' thermal readings. Throws Error if a
/// spread is not declared.
Truth draw_truth(const Session& procedure, std::uint64_t seed, const std::optional<SensorModel>& given = {});

/// Simulates the samples of `source` from 0 to the end of the last step, or those inside steps, at rate_hz (default 100); `seed` determines the
/// noise. A sample is the raw value of the mean motion over its interval plus noise, rounded to the resolution and limited to the range and the
/// source's limits (SI or counts). Without `rig` the rig is exact. The result is bit-identical for any number of threads.
Recording simulate_recording(const Session& procedure, const RecordingSource& source, const Truth& truth, std::uint64_t seed,
                             const RigErrors& rig = {});

}  // namespace imulab
