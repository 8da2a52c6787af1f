// For tests of the turntable: readings of an IMU at the level of rest means and turn sums.
#pragma once

#include "imulab/coefficient.hpp"
#include "imulab/core/decomposition.hpp"
#include "imulab/core/random.hpp"
#include "imulab/estimate/turntable/estimator.hpp"
#include "imulab/estimate/turntable/turntable.hpp"
#include "imulab/rig/table_readings.hpp"
#include "imulab/units.hpp"

#include "tests/table_steps.hpp"

namespace imulab {

/// An IMU drawn with misalignments of 1e-3 and scale factors of 1 %, and its noise: navigation grade, in counts.
inline SensorModel drawn_unit(std::uint64_t seed) {
  const RandomStream draws(seed, "unit");
  std::uint64_t next = 0;
  const auto normal = [&] { return draws.normal(next++); };
  SensorModel model;
  for (auto* triad : {&model.accel, &model.gyro}) {
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) triad->matrix(i, j) += (i == j ? 1e-2 : 1e-3) * normal();
    for (int i = 0; i < 3; ++i) triad->offset[i] = (triad == &model.accel ? 100 * unit::ug : 0.1 * unit::deg_per_h) * normal();
  }
  return model;
}

inline constexpr double table_accel_noise = 5 * unit::ug_per_sqrt_hz, table_gyro_noise = 0.001 * unit::deg_per_sqrt_h;

inline ImuDeclaration table_imu() {
  ImuDeclaration imu;
  imu.accel_noise_density = table_accel_noise;
  imu.gyro_noise_density = table_gyro_noise;
  return imu;
}

/// A standard normal vector.
inline Eigen::VectorXd drawn_normals(Eigen::Index size, std::uint64_t seed, const char* purpose) {
  const RandomStream draws(seed, purpose);
  Eigen::VectorXd v(size);
  for (Eigen::Index i = 0; i < size; ++i) v[i] = draws.normal(static_cast<std::uint64_t>(i));
  return v;
}

/// Noise of the readings of `model`.
inline Eigen::VectorXd drawn_noise(const TableMotion& motion, const SensorModel& model, std::uint64_t seed) {
  const Eigen::MatrixXd covariance = noise_covariance(motion, turntable::raw_density(table_accel_noise, model.accel.matrix),
                                                      turntable::raw_density(table_gyro_noise, model.gyro.matrix));
  return Cholesky(covariance).lower() * drawn_normals(motion.rows(), seed, "noise");
}

/// Offsets and matrices.
inline std::vector<CoefficientIndex> linear_terms() {
  std::vector<CoefficientIndex> terms;
  for (const char* selector : {"accel.offset", "accel.matrix", "gyro.offset", "gyro.matrix"})
    for (const CoefficientIndex index : select_coefficients(selector)) terms.push_back(index);
  return terms;
}

/// A procedure's readings, with the noise of the IMU times `noise`.
struct TableRun {
  TableObservations seen;
  TableMotion motion;
  SensorModel truth;
};

inline TableRun run_of(const std::vector<Step>& steps, const RigDeclaration& rig, std::uint64_t seed, double noise,
                       const Eigen::VectorXd& table_errors = {}) {
  TableObservations seen;
  seen.parts = table_plan(steps, 5 * rig.timing.value);
  TableMotion motion(seen.parts, rig, table_site());
  const SensorModel truth = drawn_unit(seed);
  const Eigen::VectorXd errors = table_errors.size() > 0 ? table_errors : motion.nominal();
  seen.readings = readings(motion, truth, motion.truth(errors)) + noise * drawn_noise(motion, truth, seed);
  return {seen, motion, truth};
}

}  // namespace imulab
