#include "imulab/estimate/rest.hpp"

#include <Eigen/Geometry>

#include <cmath>

namespace imulab {

namespace {

double mean_of(const std::vector<double>& column, Range range) {
  const double origin = column[range.begin];  // sums stay small next to raw counts
  double sum = 0;
  for (std::size_t i = range.begin; i < range.end; ++i) sum += column[i] - origin;
  return origin + sum / static_cast<double>(range.size());
}

double squares_about(const std::vector<double>& column, Range range, double mean) {
  double sum = 0;
  for (std::size_t i = range.begin; i < range.end; ++i) sum += (column[i] - mean) * (column[i] - mean);
  return sum;
}

}  // namespace

std::vector<Rest> summarize_rests(const Recording& recording, const std::vector<Range>& ranges) {
  std::vector<Rest> rests;
  for (const Range& range : ranges) {
    Rest rest;
    rest.range = range;
    rest.mid_s = 0.5 * (recording.time_s(range.begin) + recording.time_s(range.end - 1));
    for (int j = 0; j < 3; ++j) {
      rest.accel[j] = mean_of(recording.accel[j], range);
      rest.gyro[j] = mean_of(recording.gyro[j], range);
    }
    rests.push_back(rest);
  }
  return rests;
}

SampleNoise measure_noise(const Recording& recording, const std::vector<Rest>& rests) {
  Vector3d accel = Vector3d::Zero(), gyro = Vector3d::Zero();
  double degrees = 0;
  for (const Rest& rest : rests) {
    for (int j = 0; j < 3; ++j) {
      accel[j] += squares_about(recording.accel[j], rest.range, rest.accel[j]);
      gyro[j] += squares_about(recording.gyro[j], rest.range, rest.gyro[j]);
    }
    degrees += static_cast<double>(rest.range.size()) - 1;
  }
  return {(accel / std::max(degrees, 1.0)).cwiseSqrt(), (gyro / std::max(degrees, 1.0)).cwiseSqrt()};
}

Vector3d IntegratedRotation::change(const TriadModel& from, const Matrix3d& from_g, const TriadModel& to, const Matrix3d& to_g) const {
  Vector3d dphi = phi[0] * (to.offset - from.offset);
  for (Eigen::Index j = 0; j < 3; ++j) {
    dphi += phi[static_cast<std::size_t>(1 + j)] * (to.matrix.col(j) - from.matrix.col(j));
    dphi += phi[static_cast<std::size_t>(4 + j)] * (to_g.col(j) - from_g.col(j));
  }
  return dphi;
}

IntegratedRotation integrate_rotation(const Recording& recording, Range range, const SensorModel& model, const Scaling& scaling,
                                      const Vector3d& gyro_sigma) {
  IntegratedRotation sum;
  sum.C.setIdentity();
  for (Matrix3d& phi : sum.phi) phi.setZero();
  sum.covariance.setZero();
  sum.duration_s = 0;

  const Matrix3d noise = model.gyro.matrix * gyro_sigma.cwiseAbs2().asDiagonal() * model.gyro.matrix.transpose();
  const Vector3d accel_gain = scaling.accel_scale.cwiseInverse(), gyro_gain = scaling.gyro_scale.cwiseInverse();
  Vector3d previous = Vector3d::Zero();
  for (std::size_t i = range.begin; i < range.end; ++i) {
    const Vector3d va = (Vector3d(recording.accel[0][i], recording.accel[1][i], recording.accel[2][i]) - scaling.accel_center).cwiseProduct(accel_gain);
    const Vector3d vg = (Vector3d(recording.gyro[0][i], recording.gyro[1][i], recording.gyro[2][i]) - scaling.gyro_center).cwiseProduct(gyro_gain);
    const Vector3d force = model.accel.offset + model.accel.matrix * va;
    const Vector3d rate = model.gyro.offset + model.gyro.matrix * vg + model.g_sensitivity * force;
    const double dt = recording.gyro_increment || i == 0 ? recording.interval_s : 1e-9 * static_cast<double>(recording.time_ns[i] - recording.time_ns[i - 1]);
    const Vector3d angle = rate * dt;
    const Matrix3d before = sum.C;
    sum.C = before * rotation_exp(angle + previous.cross(angle) / 12);  // coning, one interval plus the previous
    previous = angle;
    const Matrix3d middle = (0.5 * dt) * (before + sum.C);  // C at the middle of the interval, times dt
    sum.phi[0] += middle;
    for (int j = 0; j < 3; ++j) {
      sum.phi[1 + j] += middle * vg[j];
      sum.phi[4 + j] += middle * force[j];
    }
    sum.covariance += middle * noise * middle.transpose();
    sum.duration_s += dt;
  }
  return sum;
}

}  // namespace imulab
