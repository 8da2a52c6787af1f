#include "imulab/estimate/whole_unit/whole_unit.hpp"

#include "imulab/core/error.hpp"
#include "imulab/estimate/kernel/plausibility.hpp"
#include "imulab/estimate/whole_unit/quality.hpp"
#include "imulab/estimate/whole_unit/starting_model.hpp"
#include "imulab/estimate/whole_unit/stepwise.hpp"
#include "imulab/model/gauge.hpp"
#include "imulab/recording/declared_noise.hpp"
#include "imulab/recording/validate.hpp"
#include "imulab/rig/ideal_recording.hpp"

#include <fmt/core.h>

#include <algorithm>

namespace imulab::whole_unit {

using Eigen::Index;
using Eigen::MatrixXd;
using kernel::Role;

namespace {

/// Throws Error where a scale came out far from that of the declared unit.
void check_units(const Problem& problem) {
  for (std::size_t k = 0; k < problem.role.size(); ++k) {
    const Coefficient& c = coefficient(problem.coefficients[k]);
    const TriadModel& m = triad_model(problem.model, c.triad);
    if (problem.role[k] != Role::estimated || !is_scale(c) || m.raw_unit == "count") continue;
    const double scale = m.matrix(c.row, c.row);
    if (scale > 0.5 && scale < 2) continue;
    const std::string_view unit = kernel::mistaken_unit(c.triad, scale);
    throw Error(fmt::format("{}: {} comes out as {:.4g} for readings in {}{}; check the unit, the columns and the machines' numbers",
                            problem.session->file, c.name, scale, m.raw_unit, unit.empty() ? "" : fmt::format(", as if they were in {}", unit)));
  }
}

void expect_latitude(const Session& session) {
  if (!session.site.latitude)
    throw Error(session.file + ": the site has no latitude; expected one, as the gyros measure the Earth's rate on every machine");
}

/// Coefficients and covariance of the readings, from those of readings less their center; the covariance may have more parameters after theirs. What
/// is not estimated keeps its starting value; of that only the terms left out count in the covariance themselves.
void set_estimate(Calibration& calibration, const Problem& problem, const std::vector<std::size_t>& left_out, SensorModel model,
                  MatrixXd covariance) {
  for (std::size_t k = 0; k < problem.role.size(); ++k) {
    if (problem.role[k] == Role::estimated) continue;
    set_coefficient(model, problem.coefficients[k], coefficient_value(problem.start, problem.coefficients[k]));
    if (std::find(left_out.begin(), left_out.end(), k) != left_out.end()) continue;
    covariance.row(static_cast<Index>(k)).setZero(), covariance.col(static_cast<Index>(k)).setZero();
  }
  const auto change = [&](const SensorModel& m) { return of_shifted_readings(m, problem.center.head<3>(), problem.center.tail<3>()); };
  calibration.model = change(model);
  const Index n = std::ssize(problem.coefficients);
  covariance = covariance_after(change, problem.coefficients, covariance.topLeftCorner(n, n));
  std::vector<Index> kept;
  for (std::size_t k = 0; k < problem.role.size(); ++k) {
    const auto i = static_cast<Index>(k);
    if (problem.role[k] != Role::estimated && !(covariance(i, i) > 0)) continue;  // uncertain where it follows an estimated one
    kept.push_back(i);
    calibration.estimated.push_back(problem.coefficients[k]);
  }
  calibration.covariance = covariance(kept, kept);
}

}  // namespace

CalibrationResult calibrate(const CalibrationInput& input, const CalibrationOptions& options) {
  const Session& session = input.session;
  for (const Recording& recording : input.recordings) validate(recording);
  if (options.whole_unit.stepwise && !options.terms.empty())
    throw TermsError("terms cannot be chosen for the stepwise estimate: Dai's steps estimate all coefficients");
  expect_latitude(session);
  const MachinePoints points = machine_points(input.recordings, session);
  const Vector6d center = reading_center(points);
  const SensorModel start = starting_model(points, session, center);
  check_mounts(points, session, start, center);

  Problem problem(points, session, start, center);
  JointEstimate joint = joint_estimate(problem, options);
  check_units(problem);
  CalibrationResult result;
  Calibration& calibration = result.calibration;
  calibration.imu = session.imu.name;
  calibration.method = options.whole_unit.stepwise ? "whole-unit stepwise" : "whole-unit";
  calibration.frame = "rig";
  if (options.whole_unit.stepwise) {  // residuals and rig errors stay those of the joint fit: they are the data's, not the estimate's
    const StepwiseEstimate steps = stepwise_estimate(problem, true);
    set_estimate(calibration, problem, {}, steps.model, steps.covariance * (joint.scatter * joint.scatter));
  } else {
    set_estimate(calibration, problem, joint.left_out, problem.model, joint.solution.covariance);
  }
  calibration.quality = quality_of(problem, joint);
  check_chamber(joint.findings, problem);
  kernel::add_common_doubts(joint.findings, calibration, session.site);
  kernel::conclude(calibration, joint.findings);
  return result;
}

Prediction predict(const Session& procedure, const std::vector<CoefficientIndex>& terms) {
  expect_latitude(procedure);
  const NoiseModels noise = errors_at(procedure.file, [&] { return declared_noise(procedure.imu); });
  const double rate = procedure.recordings.empty() ? 1 : procedure.recordings.front().rate_hz.value_or(default_sample_rate);
  Vector6d variance;
  variance << Vector3d::Constant(noise.accel.N * noise.accel.N * rate), Vector3d::Constant(noise.gyro.N * noise.gyro.N * rate);
  const MachinePoints points = planned_points(procedure, variance);
  const Vector6d center = reading_center(points);
  Problem problem(points, procedure, starting_model(points, procedure, center), center);
  for (MachinePoint& point : problem.points.all) {  // with the errors of the machines that are known exactly
    const Motion motion = problem.motion(point);
    point.raw << motion.force, motion.rate;
  }
  CalibrationOptions options;
  options.terms = terms;
  options.whole_unit.full = true;  // a term that is left out counts in the covariance all the same
  const JointEstimate joint = joint_estimate(problem, options);
  Calibration calibration;
  calibration.frame = "rig";
  set_estimate(calibration, problem, joint.left_out, problem.model, joint.solution.covariance);
  calibration.quality = quality_of(problem, joint);
  return prediction_of(calibration);
}

}  // namespace imulab::whole_unit
