// Readings centered and scaled, so that the equations are well conditioned whatever the raw unit, and the sensor model of such readings.
#pragma once

#include "imulab/eigen.hpp"
#include "imulab/recording/rest_means.hpp"
#include "imulab/sensor_model.hpp"

#include <vector>

namespace imulab {

/// v = (reading - center) / scale, per axis.
struct Scaling {
  Vector3d accel_center = Vector3d::Zero(), accel_scale = Vector3d::Ones();
  Vector3d gyro_center = Vector3d::Zero(), gyro_scale = Vector3d::Ones();

  Vector3d accel(const Vector3d& reading) const { return (reading - accel_center).cwiseQuotient(accel_scale); }
  Vector3d gyro(const Vector3d& reading) const { return (reading - gyro_center).cwiseQuotient(gyro_scale); }
};

/// Readings in counts are centered on the rests and scaled by gravity and by the motion; readings in SI stay as they are.
Scaling choose_scaling(const Recording& recording, const std::vector<RestMeans>& rests);

/// Specific force and angular rate of scaled readings, by the linear terms of a model.
inline Vector3d linear_output(const TriadModel& triad, const Vector3d& scaled) { return triad.offset + triad.matrix * scaled; }
/// With the quadratic and the cubic ones.
inline Vector3d output(const TriadModel& triad, const Vector3d& scaled) {
  const Vector3d square = scaled.cwiseAbs2();
  return linear_output(triad, scaled) + triad.quadratic.cwiseProduct(square) + triad.cubic.cwiseProduct(square.cwiseProduct(scaled));
}

/// The model of scaled readings, of raw readings: a = A0 + A1 V + A2 V^2 + A3 V^3 with V = (U - center) / scale.
SensorModel to_raw(const SensorModel& scaled, const Scaling& scaling);
SensorModel to_scaled(const SensorModel& raw, const Scaling& scaling);

}  // namespace imulab
