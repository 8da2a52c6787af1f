// The starting point of the methods that work on rests: the rests' means, their noise, and the accelerometers' coarse solution.
#pragma once

#include "imulab/estimate/kernel/findings.hpp"
#include "imulab/estimate/kernel/scaling.hpp"

#include <string_view>
#include <vector>

namespace imulab::kernel {

struct RestStart {
  std::vector<Rest> rests;
  SampleNoise noise;  ///< raw
  Scaling scaling;
  SensorModel model;  ///< of scaled readings: the accelerometers from the rests, the gyros as declared
  SensorModel prior;  ///< likewise, the prior: the declared IMU; for counts the coarse solution
  Findings findings;

  Vector3d accel(const Rest& rest) const { return scaling.accel(rest.accel); }
  Vector3d gyro(const Rest& rest) const { return scaling.gyro(rest.gyro); }
  /// Direction of gravity at a rest, in body axes.
  Vector3d up(const Rest& rest) const { return linear(model.accel, accel(rest)).normalized(); }
  /// Mean gyro reading of all rests, raw.
  Vector3d mean_gyro() const;
};

/// Throws Unsupported for too few or too similar rests, Error where the accelerometers' declared unit contradicts gravity [m/s^2].
RestStart start_from_rests(const Recording& recording, const std::vector<Range>& rests, const ImuDeclaration& imu, double gravity);

/// Is this coarse matrix of SI readings that of a sensor whose axes and unit are as declared?
bool near_identity(const Matrix3d& matrix);

/// Puts the declared gyro noise density in place of the measured noise, once `start.model` has the gyros' matrix.
void use_declared_gyro_noise(RestStart& start, const Recording& recording, const ImuDeclaration& imu);

/// A stuck or coarsely quantized axis shows no noise; a hundred-millionth of the scale keeps the weights finite.
void limit_noise(RestStart& start);

/// Sets those of `supplied` that are not in `estimated` to their prior. Throws TermsError for offsets and scales of counts among them.
void keep_prior_of_others(RestStart& start, const std::vector<CoefficientIndex>& estimated, const std::vector<CoefficientIndex>& supplied);

/// Throws Unsupported where an axis reads the same in every sample.
void expect_alive(const Columns3& triad, std::string_view file, std::string_view name, std::string_view consequence);

/// The accelerometer coefficients in the accelerometers' frame: offsets and the lower triangle of the matrix.
std::vector<CoefficientIndex> accel_coefficients();

/// Those of `supplied` that are `wanted`, all of them where none is named. Throws TermsError naming one that the method does not estimate.
std::vector<CoefficientIndex> chosen_coefficients(const std::vector<CoefficientIndex>& wanted, const std::vector<CoefficientIndex>& supplied,
                                                  std::string_view method);

}  // namespace imulab::kernel
