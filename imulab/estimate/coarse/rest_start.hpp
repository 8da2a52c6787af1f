// The starting point of the methods that work on rests: the rests' means, their noise, and the accelerometers' coarse solution.
// And whether the gyros turn with the accelerometers: those of another recording, or on another clock, do not, and no method can calibrate them.
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
  double first_s = 0;  ///< stamp of the recording's first sample, from which people count
  SampleNoise noise;   ///< raw
  MeanNoise means;     ///< of the rests' means, raw
  Scaling scaling;
  SensorModel model;        ///< of scaled readings: the accelerometers from the rests, the gyros as declared
  SensorModel prior;        ///< likewise, the prior: the declared IMU; for counts the coarse solution
  kernel::Effects effects;  ///< once a method has chosen its coefficients
  std::optional<kernel::RecordedStates> recorded;
  std::vector<EffectState> states;  ///< of the rests: what does not follow from the means; empty without effects
  bool named = false;               ///< the user named the coefficients to estimate
  kernel::Findings findings;

  Vector3d accel(const RestMeans& rest) const { return scaling.accel(rest.accel); }
  Vector3d gyro(const RestMeans& rest) const { return scaling.gyro(rest.gyro); }
  /// Direction of gravity at a rest, in body axes.
  Vector3d up(const RestMeans& rest) const { return linear_output(model.accel, accel(rest)).normalized(); }
};

/// Throws Unsupported for too few or too similar rests, Error where the accelerometers' declared unit contradicts gravity [m/s^2].
RestStart start_from_rests(const CalibrationInput& input, std::string_view method);
RestStart start_from_rests(const Recording& recording, const std::vector<Range>& rests, const ImuDeclaration& imu, double gravity);

/// Is this coarse matrix of SI readings that of a sensor whose axes and unit are as declared?
bool near_identity(const Matrix3d& matrix);

/// What the rests show of the unit, by which its grade is told.
kernel::SeenOfUnit seen_of(const RestStart& start, const Recording& recording, double gravity);

/// Puts the declared gyro noise density in place of the measured noise, once `start.model` has the gyros' matrix.
void use_declared_gyro_noise(RestStart& start, const Recording& recording, const ImuDeclaration& imu);

/// A stuck or coarsely quantized axis shows no noise; a hundred-millionth of the scale keeps the weights finite.
void limit_noise(RestStart& start);

/// The part of gravity's turning in the IMU from rest to rest that the gyros explain: 1 all, 0 as little as gyros that read nothing. Turns of less
/// than 10 deg, with a gap or with saturated samples do not count; empty where fewer than three others are. `gyro`: the matrix of scaled readings.
std::optional<double> explained_turning(const Recording& recording, const RestStart& start, const Matrix3d& gyro);

/// The gyros' coarse matrix in motion (coarse.hpp); nothing where it is not that of the declared IMU and the declared unit explains the turns better
/// (gyros that are late by part of a turn make any), or where the turns that would tell were lost. Throws Unsupported where the gyros explain less
/// than half, with the coarse matrix and, where their unit is declared, as they are.
std::optional<Matrix3d> coarse_gyro_in_common_turns(const Recording& recording, const RestStart& start);

}  // namespace imulab::coarse
