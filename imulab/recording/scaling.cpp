#include "imulab/recording/scaling.hpp"

#include "imulab/core/statistics.hpp"
#include "imulab/model/gauge.hpp"

#include <algorithm>
#include <cmath>

namespace imulab {

Scaling choose_scaling(const Recording& recording, const std::vector<RestMeans>& rests) {
  Scaling scaling;
  if (recording.accel_unit == "count") {
    // Midrange and half range of the rests: gravity up and down.
    const auto [low, high] = accel_extremes(rests);
    scaling.accel_center = 0.5 * (low + high);
    const double scale = 0.5 * (high - low).maxCoeff();
    scaling.accel_scale.setConstant(scale > 0 ? scale : 1.0);
  }
  if (recording.gyro_unit == "count") {
    for (int j = 0; j < 3; ++j) {
      const std::vector<double>& readings = recording.gyro[static_cast<std::size_t>(j)];
      std::vector<double> means, samples;
      for (const RestMeans& rest : rests) means.push_back(rest.gyro[j]);
      scaling.gyro_center[j] = median(means);
      const std::size_t stride = std::max<std::size_t>(1, recording.size() / 4096);
      for (std::size_t i = 0; i < recording.size(); i += stride) samples.push_back(std::abs(readings[i] - scaling.gyro_center[j]));
      scaling.gyro_scale[j] = std::max(1e-300, quantile(samples, 0.95));
    }
    scaling.gyro_scale.setConstant(scaling.gyro_scale.maxCoeff());
  }
  return scaling;
}

namespace {

TriadModel rescaled(TriadModel model, const Vector3d& by) {
  const Vector3d square = by.cwiseAbs2();
  model.matrix = model.matrix * by.asDiagonal();
  model.quadratic = model.quadratic.cwiseProduct(square);
  model.cubic = model.cubic.cwiseProduct(square.cwiseProduct(by));
  model.thermal = by.cwiseInverse().asDiagonal() * model.thermal;
  return model;
}

TriadModel to_raw(const TriadModel& scaled, const Vector3d& center, const Vector3d& scale) {
  return of_shifted_readings(rescaled(scaled, scale.cwiseInverse()), center);
}

TriadModel to_scaled(const TriadModel& raw, const Vector3d& center, const Vector3d& scale) {
  return rescaled(of_shifted_readings(raw, -center), scale);
}

}  // namespace

SensorModel to_raw(const SensorModel& scaled, const Scaling& scaling) {
  SensorModel raw = scaled;
  raw.accel = to_raw(scaled.accel, scaling.accel_center, scaling.accel_scale);
  raw.gyro = to_raw(scaled.gyro, scaling.gyro_center, scaling.gyro_scale);
  return raw;
}

SensorModel to_scaled(const SensorModel& raw, const Scaling& scaling) {
  SensorModel scaled = raw;
  scaled.accel = to_scaled(raw.accel, scaling.accel_center, scaling.accel_scale);
  scaled.gyro = to_scaled(raw.gyro, scaling.gyro_center, scaling.gyro_scale);
  return scaled;
}

}  // namespace imulab
