// True motion, a true IMU and noise -> a recording. In memory, on values: the command, tests and Monte Carlo runs use the same call.
//
// Example:
//   const Session procedure = dai_unit_procedure({});
//   const Truth truth = draw_truth(procedure, 1);
//   const RecordingSource& source = procedure.recordings.front();
//   const Recording simulated = simulate_recording(procedure, source, truth, 1, draw_rig_errors(procedure, source, 1));
//
// The error sources of a rig are one flat list:
// - orthogonality: l_outer = (o1, o2, 1), l_middle = (m1, 1, m2), l_inner = (1, i1, i2) in n at zero angles, then normalized;
// - zero: a constant angle error of each axis (outer: north; middle and inner: the IMU's level at zero angles);
// - tilt: the whole table is tilted about east and about north;
// - angle: angle error of a stop. An axis has one from the start and draws a new one only when it is commanded to move;
// - timing: a commanded rotation lasts longer by this time, and ends at its angle;
// - mount, rate, radius: of rate table and centrifuge.
// A table with fewer axes is one whose procedure does not use the others: an axis that stays at zero throughout has neither orthogonality nor angle
// errors (its zero error remains: the IMU's mounting).
//
// A draw depends on the seed and on what is drawn alone: equal seeds give equal bits, on any number of threads. SI. Throw Error where a procedure
// lacks a latitude, noise or a spread. Time is linear in the number of samples. Safe on any thread.
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
  std::size_t axis = 0;         ///< by RigAxis; of a tilt: 0 about east, 1 about north; of a mount: the body axis it turns about
  std::size_t element = 0;      ///< of an orthogonality: 0 or 1, as in i1, i2
  std::size_t step = at_start;  ///< of an angle or timing error: the step (of its recording) that draws it, from 0
  Mount place{};                ///< of a mount or radius: which
  double known = 0;             ///< rad, s, m or relative: the declared value; the mean of the draws
  double sigma = 0;             ///< likewise: of its draw; 0 where it is known exactly

  /// "orthogonality.inner.1", "zero.outer", "tilt.east", "angle.middle.start", "angle.middle.12", "timing.3": steps count from 1; of machines "rate",
  /// "mount.+z+x.y", "radius.+z+x".
  std::string name() const;
  bool operator==(const RigErrorSource&) const = default;
};

/// Every error source of a recording's rig, as declared: of the table or machine first, then by step or mount. A hand (kind none)
/// has none.
std::vector<RigErrorSource> rig_error_sources(const Session& session, const RecordingSource& source);

/// Error sources and their values. Empty: a rig without errors.
struct RigErrors {
  std::vector<RigErrorSource> sources = {};
  std::vector<double> values = {};  ///< rad, s, m or relative
};

/// One draw. Recordings on one rig share its table errors; each has its own angle and timing errors.
RigErrors draw_rig_errors(const Session& session, const RecordingSource& source, std::uint64_t seed);

/// What a unit does beside the sensor model, exactly (docs/theory/effects.md).
struct EffectValue {
  std::string name = {};  ///< "accel.asymmetry"
  int column = 0;         ///< of an effect that has several
  double value = 0;       ///< SI
};

/// The exact values of a simulation, which a calibration should find.
struct Truth {
  SensorModel model;
  double gravity = 0;                           ///< m/s^2
  std::optional<double> latitude{};             ///< rad; absent: the site's
  BodyFrame frame = BodyFrame::accelerometers;  ///< of the model
  NoiseModel accel_noise{}, gyro_noise{};       ///< errors that are not coefficients of the model; a calibration of one recording does not find them
  std::vector<EffectValue> effects{};           ///< of [imu.effects]
};

/// Draws the IMU from imu.grade (or takes `given`), and gravity and latitude from the site's values and sigmas. Declared noise replaces the
/// grade's, of which only white noise is taken unless imu.noise asks for all terms. In the accelerometers' frame (the accelerometer matrix is lower
/// triangular), but in the rig's for a grade with ranges. Thermal terms are those of the recordings' readings. Throws Error where a spread is not
/// declared.
Truth draw_truth(const Session& procedure, std::uint64_t seed, const std::optional<SensorModel>& given = {});

/// Samples from 0 to the end of the last step, or those inside the steps, at rate_hz (100 where absent). Each is the raw value of the mean motion
/// over its interval plus the noise terms, rounded to the resolution and clipped to the range and to the source's limits (SI or counts). Without
/// `rig` the rig is exact. Bit-equal on any number of threads.
Recording simulate_recording(const Session& procedure, const RecordingSource& source, const Truth& truth, std::uint64_t seed,
                             const RigErrors& rig = {});

}  // namespace imulab
