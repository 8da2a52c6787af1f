// For tests of the turntable: Zhang's procedure (2010, section 2) and readings of a unit at the level of rest means and turn sums.
#pragma once

#include "imulab/core/random.hpp"
#include "imulab/core/units.hpp"
#include "imulab/estimate/turntable.hpp"
#include "imulab/estimate/turntable_estimator.hpp"
#include "imulab/model/coefficient.hpp"
#include "imulab/recording/turn.hpp"

#include <Eigen/Cholesky>

namespace imulab {

/// Lays out steps in time: rests, turns at 10 deg/s and 50 deg/s^2, and 10 s for reaching a hold.
class TableSteps {
 public:
  TableSteps& hold(double duration, std::array<double, 3> degrees) {
    Step step;
    std::array<double, 3> angles{};
    for (std::size_t a = 0; a < 3; ++a) angles[a] = degrees[a] * unit::deg;
    step.start = time_ + (angles == angles_ ? 0 : 10);
    step.end = step.start + duration;
    step.angles = angles_ = angles;
    return append(step);
  }
  TableSteps& turn(RigAxis axis, double degrees, double dps = 10) {
    Step step;
    step.kind = StepKind::rotate;
    step.axis = axis;
    step.angle = degrees * unit::deg;
    step.rate = dps * unit::deg;
    step.acceleration = 50 * unit::deg;
    step.start = time_;
    step.end = time_ + turn_duration(degrees, dps, 50);
    step.angles = angles_;
    angles_[static_cast<std::size_t>(axis)] += step.angle;
    return append(step);
  }
  const std::vector<Step>& steps() const { return steps_; }

 private:
  TableSteps& append(Step step) {
    step.recording = "recording.csv";
    time_ = step.end;
    steps_.push_back(step);
    return *this;
  }
  double time_ = 0;
  std::array<double, 3> angles_{};
  std::vector<Step> steps_;
};

/// Five turns forward and back about each axis with rests of 60 s, at zero angles; then six faces up with four headings each.
inline std::vector<Step> zhang_steps() {
  TableSteps steps;
  for (const RigAxis axis : {RigAxis::middle, RigAxis::outer, RigAxis::inner})
    steps.hold(60, {})
        .turn(axis, 1800)
        .hold(60, {axis == RigAxis::outer ? 1800.0 : 0, axis == RigAxis::middle ? 1800.0 : 0, axis == RigAxis::inner ? 1800.0 : 0})
        .turn(axis, -1800)
        .hold(60, {});
  // Inner and middle angle of x, y, z up and x, y, z down in Zhang's north-up-east axes.
  constexpr std::array<std::array<double, 2>, 6> faces{{{90, 0}, {0, 0}, {0, -90}, {-90, 0}, {0, 180}, {0, 90}}};
  for (const auto& [inner, middle] : faces)
    for (const double outer : {0.0, 90.0, 180.0, -90.0}) steps.hold(60, {outer, middle, inner});
  return steps.steps();
}

/// A table with this accuracy of angles, orthogonality and zero, and 10 ms.
inline RigDeclaration table_of(double sigma, double timing = 0.01) {
  RigDeclaration rig;
  rig.kind = RigKind::turntable;
  rig.angle.value = rig.orthogonality.value = rig.zero.value = sigma;
  rig.timing.value = timing;
  return rig;
}

inline Site table_site() {
  Site site;
  site.latitude = 28 * unit::deg;
  site.given_gravity = 9.79;
  return site;
}

/// A unit drawn with misalignments of 1e-3 and scales of 1 % and its noise: a navigation-grade unit in counts.
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
  const Eigen::MatrixXd covariance =
      noise_covariance(motion, raw_density(table_accel_noise, model.accel.matrix), raw_density(table_gyro_noise, model.gyro.matrix));
  return covariance.llt().matrixL() * drawn_normals(motion.rows(), seed, "noise");
}

/// Offsets and matrices.
inline std::vector<int> linear_terms() {
  std::vector<int> terms;
  for (const char* selector : {"accel.offset", "accel.matrix", "gyro.offset", "gyro.matrix"})
    for (const int index : select_coefficients(selector)) terms.push_back(index);
  return terms;
}

/// A procedure's readings, with the noise of the unit times `noise`.
struct TableRun {
  TableObservations seen;
  TableMotion motion;
  SensorModel truth;
};

inline TableRun run_of(const std::vector<Step>& steps, const RigDeclaration& rig, std::uint64_t seed, double noise,
                       const Eigen::VectorXd& table_errors = {}) {
  TableObservations seen = planned_observations(steps, 5 * rig.timing.value);
  TableMotion motion(seen, rig, table_site());
  const SensorModel truth = drawn_unit(seed);
  const Eigen::VectorXd errors = table_errors.size() > 0 ? table_errors : motion.nominal();
  seen.set_values(readings(motion, truth, motion.truth(errors)) + noise * drawn_noise(motion, truth, seed));
  return {seen, motion, truth};
}

}  // namespace imulab
