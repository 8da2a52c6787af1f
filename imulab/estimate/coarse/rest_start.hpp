// The start of the methods that use rests: means of the rests, their noise, and the coarse solution of the accelerometers. Also checks whether the
// gyros turn with the accelerometers: if they belong to another recording or clock, no method can calibrate them.
#pragma once

#include "imulab/calibrate.hpp"
#include "imulab/estimate/kernel/effects.hpp"
#include "imulab/estimate/kernel/findings.hpp"
#include "imulab/estimate/kernel/prior.hpp"
#include "imulab/estimate/kernel/recorded_states.hpp"
#include "imulab/estimate/method.hpp"
#include "imulab/recording/mean_noise.hpp"
#include "imulab/recording/scaling.hpp"

#include <optional>
#include <string_view>
#include <vector>

namespace imulab::coarse {

struct RestStart {
  std::vector<RestMeans> rests;
  double first_s = 0;  ///< stamp of the recording's first sample, the zero of times in messages
  SampleNoise noise;   ///< raw
  MeanNoise means;     ///< noise of the rests' means, raw
  Scaling scaling;
  SensorModel model;        ///< model of scaled readings: accelerometers from the rests, gyros as declared
  SensorModel prior;        ///< prior, likewise: the declared IMU; for counts the coarse solution
  kernel::Effects effects;  ///< set after a method has chosen its coefficients
  std::optional<kernel::RecordedStates> recorded;
  std::vector<EffectState> states;  ///< states of the rests that do not follow from the means; empty without effects
  bool named = false;               ///< the user named the coefficients to estimate
  kernel::Findings findings;

  Vector3d accel(const RestMeans& rest) const { return scaling.accel(rest.accel); }
  Vector3d gyro(const RestMeans& rest) const { return scaling.gyro(rest.gyro); }
  /// Returns the direction of gravity at a rest, in body axes.
  Vector3d up(const RestMeans& rest) const { return linear_output(model.accel, accel(rest)).normalized(); }
};

/// Computes the start. Throws Unsupported for too few or too similar rests, and Error if the accelerometers' unit contradicts gravity [m/s^2].
RestStart start_from_rests(const CalibrationInput& input, std::string_view method);
RestStart start_from_rests(const Recording& recording, const std::vector<Range>& rests, const ImuDeclaration& imu, double gravity);

/// Returns true if this coarse matrix of SI readings belongs to a sensor with axes and unit as declared.
bool near_identity(const Matrix3d& matrix);

/// Returns the observed properties of the unit that indicate its grade.
kernel::SeenOfUnit seen_of(const RestStart& start, const Recording& recording, double gravity);

/// Replaces the measured noise by the declared gyro noise density, after `start.model` has the gyro matrix.
void use_declared_gyro_noise(RestStart& start, const Recording& recording, const ImuDeclaration& imu);

/// Limits the noise from below: a stuck or coarsely quantized axis has none, and 1e-8 of the scale keeps its weights finite.
void limit_noise(RestStart& start);

/// Returns the fraction of gravity's turning between rests that the gyros explain: 1 is all, 0 as for gyros with zero readings. Turns of less than 10
/// deg, with a gap or with saturated samples are skipped; empty with fewer than three others. `gyro`: matrix of scaled readings.
std::optional<double> explained_turning(const Recording& recording, const RestStart& start, const Matrix3d& gyro);

/// Returns the gyros' coarse matrix in motion (coarse.hpp). Returns nothing if it is not that of the declared IMU although the declared unit explains
/// the turns better (gyros with a delay of part of a turn give any matrix), or if the decisive turns were lost. Throws Unsupported if the gyros
/// explain less than half with the coarse matrix and, for a declared unit, as declared.
std::optional<Matrix3d> coarse_gyro_in_common_turns(const Recording& recording, const RestStart& start);

}  // namespace imulab::coarse
