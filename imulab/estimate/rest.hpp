// What the estimators use of a recording: the means of its rests, their sampling noise, and the rotations between them.
#pragma once

#include "imulab/core/rotation.hpp"
#include "imulab/model/sensor_model.hpp"
#include "imulab/recording/recording.hpp"

#include <vector>

namespace imulab {

/// One rest: means of the raw readings.
struct Rest {
  Range range;
  double mid_s = 0;  ///< middle of the rest, s of the recording's clock
  Vector3d accel, gyro;
};

std::vector<Rest> summarize_rests(const Recording& recording, const std::vector<Range>& ranges);

/// Standard deviation of one sample at rest, per axis, raw.
struct SampleNoise {
  Vector3d accel, gyro;
};

/// Pooled over the rests, about each rest's own mean.
SampleNoise measure_noise(const Recording& recording, const std::vector<Rest>& rests);

/// The rotation a range of gyro samples integrates to, with its derivatives.
/// `C` takes the body axes at the end to those at the beginning: C = prod exp(w dt), the rates as means over their intervals, coning from each
/// interval and the one before. `phi` are first-order integrals of C(t) b(t) dt for b = 1, gyro x, y, z, force x, y, z: an error dW0 + dW1 V + dC f of
/// the rate turns C into (I + [dphi x]) C with dphi = phi[0] dW0 + sum_j phi[1 + j] dW1.col(j) + sum_j phi[4 + j] dC.col(j).
struct IntegratedRotation {
  Matrix3d C;
  std::array<Matrix3d, 7> phi;
  Matrix3d covariance;  ///< of dphi from the gyros' sample noise, rad^2
  double duration_s;

  /// dphi from one linear gyro model to another.
  Vector3d change(const TriadModel& from, const Matrix3d& from_g, const TriadModel& to, const Matrix3d& to_g) const;
};

/// The model's raw input is (reading - center) / scale, per axis.
struct Scaling {
  Vector3d accel_center = Vector3d::Zero(), accel_scale = Vector3d::Ones();
  Vector3d gyro_center = Vector3d::Zero(), gyro_scale = Vector3d::Ones();
};

/// Integrates the samples of `range`, which has no gap inside. The model is linear (offset, matrix, g-sensitivity) in scaled readings.
IntegratedRotation integrate_rotation(const Recording& recording, Range range, const SensorModel& scaled_model, const Scaling& scaling,
                                      const Vector3d& gyro_sigma_scaled);

}  // namespace imulab
