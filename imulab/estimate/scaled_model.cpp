#include "imulab/estimate/scaled_model.hpp"

#include "imulab/core/statistics.hpp"

#include <algorithm>
#include <cmath>

namespace imulab {

Scaling choose_scaling(const Recording& recording, const std::vector<Rest>& rests) {
  Scaling scaling;
  if (recording.accel_unit == "count") {
    // Midrange and half range of the rests: gravity up and down.
    Vector3d low = rests.front().accel, high = low;
    for (const Rest& rest : rests) {
      low = low.cwiseMin(rest.accel);
      high = high.cwiseMax(rest.accel);
    }
    scaling.accel_center = 0.5 * (low + high);
    const double scale = 0.5 * (high - low).maxCoeff();
    scaling.accel_scale.setConstant(scale > 0 ? scale : 1.0);
  }
  if (recording.gyro_unit == "count") {
    for (int j = 0; j < 3; ++j) {
      std::vector<double> means, samples;
      for (const Rest& rest : rests) means.push_back(rest.gyro[j]);
      scaling.gyro_center[j] = median(means);
      const std::size_t stride = std::max<std::size_t>(1, recording.size() / 4096);
      for (std::size_t i = 0; i < recording.size(); i += stride) samples.push_back(std::abs(recording.gyro[j][i] - scaling.gyro_center[j]));
      scaling.gyro_scale[j] = std::max(1e-300, quantile(samples, 0.95));
    }
    scaling.gyro_scale.setConstant(scaling.gyro_scale.maxCoeff());
  }
  return scaling;
}

namespace {

TriadModel to_raw(const TriadModel& scaled, const Vector3d& center, const Vector3d& scale) {
  TriadModel raw = scaled;
  raw.matrix = scaled.matrix * scale.cwiseInverse().asDiagonal();
  raw.offset = scaled.offset - raw.matrix * center;
  return raw;
}

TriadModel to_scaled(const TriadModel& raw, const Vector3d& center, const Vector3d& scale) {
  TriadModel scaled = raw;
  scaled.matrix = raw.matrix * scale.asDiagonal();
  scaled.offset = raw.offset + raw.matrix * center;
  return scaled;
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

double Prior::sigma(const Coefficient& coefficient, double gravity) const {
  const bool accel = coefficient.triad == Triad::accel;
  switch (coefficient.term) {
    case Term::offset: return accel ? 0.2 * gravity : 1.0;
    case Term::matrix: {
      const auto row = (accel ? mean.accel : mean.gyro).matrix.row(coefficient.row);
      const bool along = std::abs(row[coefficient.row]) > 0.9 * row.norm();
      return (along && coefficient.row != coefficient.column ? 1e-2 : 0.2) * row.norm();
    }
    case Term::g_sensitivity: return 1e-3;
    default: return 0;
  }
}

Eigen::VectorXd Prior::sigmas(const std::vector<int>& indices, double gravity) const {
  Eigen::VectorXd all(static_cast<Eigen::Index>(indices.size()));
  for (std::size_t i = 0; i < indices.size(); ++i)
    all[static_cast<Eigen::Index>(i)] = sigma(coefficient_table()[static_cast<std::size_t>(indices[i])], gravity);
  return all;
}

void add_prior_rows(Conditions& conditions, Eigen::Index row, const Prior& prior, const Eigen::VectorXd& sigma, const SensorModel& model,
                    const std::vector<int>& indices) {
  for (std::size_t i = 0; i < indices.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    conditions.value[row + at] = coefficient_value(model, indices[i]) - coefficient_value(prior.mean, indices[i]);
    conditions.jacobian(row + at, at) = 1;
    conditions.kind[static_cast<std::size_t>(row + at)] = ConditionKind::prior;
    conditions.blocks.push_back({row + at, 1, Eigen::MatrixXd::Constant(1, 1, sigma[at] * sigma[at]), {}});
  }
}

Eigen::MatrixXd covariance_to_raw(const Eigen::MatrixXd& covariance, const std::vector<int>& indices, const Scaling& scaling) {
  // to_raw is linear: its matrix, column by column.
  const auto n = static_cast<Eigen::Index>(indices.size());
  Eigen::MatrixXd map(n, n);
  SensorModel zero;
  zero.accel.matrix.setZero();
  zero.gyro.matrix.setZero();
  for (Eigen::Index c = 0; c < n; ++c) {
    SensorModel unit = zero;
    set_coefficient(unit, indices[static_cast<std::size_t>(c)], 1.0);
    const SensorModel raw = to_raw(unit, scaling);
    for (Eigen::Index r = 0; r < n; ++r) map(r, c) = coefficient_value(raw, indices[static_cast<std::size_t>(r)]);
  }
  return map * covariance * map.transpose();
}

}  // namespace imulab
