#include "imulab/estimate/turntable_fit.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/units.hpp"

#include <Eigen/LU>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace imulab {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// Root mean square of what varies in three rows of every part from `first` on.
double spread(const VectorXd& v, const std::vector<Index>& at, bool about_mean) {
  Vector3d mean = Vector3d::Zero();
  if (about_mean)
    for (const Index row : at) mean += v.segment<3>(row) / static_cast<double>(at.size());
  double squares = 0;
  for (const Index row : at) squares += (v.segment<3>(row) - mean).squaredNorm();
  return std::sqrt(squares);
}

/// Readings in counts start from the size of what they read; SI readings from themselves.
SensorModel starting_model(const TableObservations& seen, const TableMotion& motion) {
  const VectorXd truth = motion.truth(motion.nominal()), values = seen.values();
  const auto holds = static_cast<Index>(motion.holds());
  std::vector<Index> force, turn_truth, turn_sum;
  for (Index k = 0; k < holds; ++k) force.push_back(6 * k);
  for (Index k = 0; k < static_cast<Index>(motion.turns()); ++k) {
    turn_truth.push_back(6 * (holds + k));
    turn_sum.push_back(6 * holds + 3 * k);
  }
  SensorModel start;
  if (seen.accel_unit == "count" && spread(truth, force, true) > 0 && spread(values, force, true) > 0)
    start.accel.matrix *= spread(truth, force, true) / spread(values, force, true);
  if (seen.gyro_unit == "count" && turn_sum.size() > 1 && spread(values, turn_sum, true) > 0)
    start.gyro.matrix *= spread(truth, turn_truth, true) / spread(values, turn_sum, true);
  return start;
}

/// The noise declared, or as the holds' samples show it; a stuck or coarsely quantised axis shows none, and a hundred-millionth of the scale keeps
/// the weights finite.
RawNoise raw_noise(const TableObservations& seen, const SensorModel& model, const ImuDeclaration& imu) {
  const auto measured = [](const Vector3d& density, const Matrix3d& matrix, double size) {
    return Matrix3d(density.cwiseMax(1e-8 * size / std::cbrt(std::abs(matrix.determinant()))).cwiseAbs2().asDiagonal());
  };
  return {
      imu.accel_noise_density ? raw_density(*imu.accel_noise_density, model.accel.matrix) : measured(seen.accel_density, model.accel.matrix, unit::g),
      imu.gyro_noise_density ? raw_density(*imu.gyro_noise_density, model.gyro.matrix) : measured(seen.gyro_density, model.gyro.matrix, 1.0)};
}

bool left_handed(const SensorModel& model) { return model.accel.matrix.determinant() < 0 || model.gyro.matrix.determinant() < 0; }

/// The steps with the sense of one axis reversed.
TableObservations reversed(TableObservations seen, std::size_t axis) {
  for (Step& step : seen.steps) {
    step.angles[axis] = -step.angles[axis];
    if (step.kind == StepKind::rotate && static_cast<std::size_t>(step.axis) == axis) step.angle = -step.angle;
  }
  return seen;
}

}  // namespace

TurntableFit fit_turntable(const TurntableProblem& problem, TurntableSettings settings) {
  SensorModel model = starting_model(problem.seen, problem.motion);
  settings.table_errors = false;
  model = TurntableEstimator(problem.motion, model, raw_noise(problem.seen, model, problem.imu), settings).estimate(problem.values);
  settings.table_errors = true;
  const auto usable = [](const SensorModel& m) {
    return m.accel.matrix.allFinite() && m.gyro.matrix.allFinite() && m.accel.matrix.determinant() != 0 && m.gyro.matrix.determinant() != 0;
  };
  for (int pass = 0;; ++pass) {
    if (!usable(model)) throw Unsupported("the readings do not follow the table's motion: a triad's readings do not span three axes");
    TurntableEstimator estimator(problem.motion, model, raw_noise(problem.seen, model, problem.imu), settings);
    const VectorXd readings = estimator.linearised(problem.values);
    model = estimator.estimate(readings);
    if (pass == 1) return {estimator, readings, model, estimator.chi2(readings)};
    settings.around = estimator.table_errors(readings);
  }
}

std::string reversed_axis(const TurntableProblem& problem, const TurntableFit& fit, const RigDeclaration& rig, const Site& site,
                          const TurntableSettings& settings) {
  const bool mirrored = left_handed(fit.model);
  if (!mirrored && fit.log_probability() > std::log(by_chance)) return {};
  std::string found;
  double best = fit.chi2 + (mirrored ? 30.0 : -30.0);  // a few sigmas of doubt where handedness speaks for it, against it where not
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const TableObservations seen = reversed(problem.seen, axis);
    const TableMotion motion(seen, rig, site);
    const TurntableFit other = fit_turntable({seen, motion, problem.imu, problem.values}, settings);
    if (left_handed(other.model) || other.chi2 >= best) continue;
    best = other.chi2;
    found = fmt::format("the {} axis seems to turn against the sign of its angles: with it reversed chi-square falls from {:.4g} to {:.4g}",
                        to_string(static_cast<RigAxis>(axis)), fit.chi2, other.chi2);
    if (mirrored) found += ", and the sensors' axes become right-handed";
  }
  if (found.empty() && mirrored) found = "a triad is left-handed in the table's axes: a sensor's or a table axis's sign is reversed";
  return found;
}

CleanedFit drop_outliers(const TurntableProblem& problem, const TurntableFit& fit, TurntableSettings& settings, double level) {
  const std::size_t parts = problem.motion.holds() + problem.motion.turns();
  const TurntableSettings before = settings;
  CleanedFit cleaned{fit, {}, {}};
  while (true) {
    const std::vector<double> log_p = cleaned.fit.estimator.log_probabilities(cleaned.fit.readings);
    const auto least = std::min_element(log_p.begin(), log_p.end());
    if (least == log_p.end() || *least > std::log(level / static_cast<double>(parts))) break;
    const auto part = static_cast<std::size_t>(least - log_p.begin());
    const std::string name = describe_step(problem.seen.steps, problem.motion.step(part));
    if (cleaned.worst.empty()) cleaned.worst = name;
    // A fifth of the steps and a third of the turns: more are not outliers but another motion.
    const auto of_turns = static_cast<std::size_t>(std::count_if(settings.left_out.begin(), settings.left_out.end(),
                                                                 [&](std::size_t p) { return p >= problem.motion.holds(); }));
    if (settings.left_out.size() >= parts / 5 || (part >= problem.motion.holds() && 3 * (of_turns + 1) > problem.motion.turns())) break;
    settings.left_out.push_back(part);
    cleaned.dropped.push_back(name);
    cleaned.fit = fit_turntable(problem, settings);
  }
  if (cleaned.fit.log_probability() > std::log(by_chance)) {
    cleaned.worst.clear();
    return cleaned;
  }
  settings = before;
  return {fit, {}, cleaned.worst};
}

}  // namespace imulab
