#include "imulab/estimate/whole_unit/whole_unit.hpp"

#include "imulab/core/decomposition.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/error.hpp"
#include "imulab/estimate/kernel/effect_findings.hpp"
#include "imulab/estimate/kernel/fit.hpp"
#include "imulab/estimate/kernel/input.hpp"
#include "imulab/estimate/kernel/plausibility.hpp"
#include "imulab/estimate/whole_unit/quality.hpp"
#include "imulab/estimate/whole_unit/stepwise.hpp"
#include "imulab/estimate/whole_unit/terms.hpp"
#include "imulab/model/gauge.hpp"
#include "imulab/recording.hpp"
#include "imulab/rig/ideal_recording.hpp"
#include "imulab/session.hpp"

#include <Eigen/Cholesky>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace imulab::whole_unit {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using kernel::Role;

namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// A fit whose suspects are its points.
struct PointFit {
  PointProblem problem;
  std::size_t may_go;  ///< number of points that may still be dropped
  kernel::Solution solution = whole_unit::fit(problem).solution();

  std::vector<kernel::Suspect> suspects() const {
    std::vector<double> statistic;
    for (const MachinePoint& point : problem.points.all) {
      const PointEquations e = problem.equations(point);
      // The misfit is predicted from the other points: I - J P J^T is the part of unit noise that the fit leaves.
      const Matrix6 remaining = Matrix6::Identity() - e.jacobian * solution.covariance * e.jacobian.transpose();
      statistic.push_back(e.white.dot(remaining.ldlt().solve(e.white)));
    }
    const double spread = std::max(1.0, median(statistic) / chi_square_quantile(0.5, 6));  // excess scatter of good points over their noise
    std::vector<kernel::Suspect> out;
    for (std::size_t k = 0; k < statistic.size(); ++k)
      out.push_back({problem.points.all[k].name(*problem.session), log_chi_square_tail(statistic[k] / spread, 6)});
    return out;
  }
  bool may_drop(std::size_t) const { return may_go > 0; }
  PointFit without(std::size_t suspect) const {
    PointProblem rest = problem;
    rest.points.all.erase(rest.points.all.begin() + static_cast<std::ptrdiff_t>(suspect));
    return {std::move(rest), may_go - 1};
  }
};

std::vector<std::string> drop_bad_points(PointProblem& problem, double outlier_level) {
  auto cleaned = kernel::drop_suspects(PointFit{problem, std::max<std::size_t>(2, problem.points.all.size() / 50)}, outlier_level);
  if (!cleaned.clean) return {};
  problem = std::move(cleaned.fit.problem);
  return std::move(cleaned.dropped);
}

/// Fixes coefficients that were not requested at their starting values.
void hold_others(PointProblem& problem, const std::vector<CoefficientIndex>& terms) {
  const std::vector<CoefficientIndex> chosen = kernel::chosen_coefficients(terms, problem.coefficients, "whole-unit");
  for (std::size_t k = 0; k < problem.role.size(); ++k)
    if (!contains(chosen, problem.coefficients[k])) problem.role[k] = Role::fixed;
}

/// Fits everything under its prior, starting from Dai's three steps if possible, else from the linear model. The steps do not include effects.
void fit_under_priors(PointProblem& problem, const CalibrationOptions& options) {
  if (options.terms.empty()) try {
      problem.model = stepwise_estimate(problem, false).model;
    } catch (const Unsupported&) {  // data that are insufficient for the steps may suffice for the joint estimate
    }
  if (options.effects && !options.whole_unit.stepwise) {
    PointProblem without = problem;
    fit(without, Priors::all);
    const Vector6d density = (without.measured_noise() * problem.points.interval_s).cwiseSqrt();
    problem.add_effects(kernel::seen_of_axes(density.head<3>(), density.tail<3>(), without.model.accel.offset, without.model.gyro.offset));
  }
  fit(problem, Priors::all);
}

/// Fits the coefficients that the data determine, with the noise for the fitted slopes.
Fit fit_determined(PointProblem& problem) {
  const kernel::Parameters parameters = problem.parameters(Priors::all);
  const kernel::Solution s = kernel::solve(problem.information(), parameters, "the points");
  for (const Index i : kernel::undetermined(s.covariance, parameters, problem.needed_sigma))
    problem.role[static_cast<std::size_t>(i)] = Role::considered;
  fit(problem);
  problem.update_noise();
  return fit(problem);
}

void check_noise(kernel::Findings& findings, const PointProblem& problem) {
  const Vector6d measured = problem.measured_noise();
  const auto check = [&](const char* name, const std::optional<double>& density, const Vector3d& variance) {
    if (density && *density > 0) kernel::check_declared_noise(findings, name, std::sqrt(variance.mean() * problem.points.interval_s) / *density);
  };
  check("accelerometers", problem.session->imu.accel_noise_density, measured.head<3>());
  check("gyros", problem.session->imu.gyro_noise_density, measured.tail<3>());
}

/// Infers the sizes of effects from the points, and fits again.
void infer_sizes(PointProblem& problem) {
  constexpr int most_rounds = 5;
  if (problem.effects.size() == 0 || problem.ideal) return;
  for (int round = 0; round < most_rounds; ++round) {
    const kernel::Parameters parameters = problem.parameters();
    if (!problem.effects.infer(parameters, kernel::solve(problem.information(), parameters, "the points"))) return;
    fit_determined(problem);
  }
}

/// The Earth's horizontal rate is equal on the other side of the equator: a wrong sign of the latitude is another minimum that steps do not reach.
/// Effects of the gyros explain part of it, at the cost of their priors. With a correct latitude, the other side is more probable by this limit in
/// one of 150 sessions of a MEMS unit, and never for better gyros.
void mirror_wrong_latitude(PointProblem& problem, kernel::Findings& findings) {
  constexpr double more_likely = 2;  // logarithm
  if (problem.effects.size() == 0) return;
  PointProblem mirrored = problem;
  mirrored.mirror_latitude();
  const auto by_more = [](PointProblem here, PointProblem there) {
    const Fit a = fit(here), b = fit(there);
    return kernel::log_probability(b.data, b.parameters, "the points") - kernel::log_probability(a.data, a.parameters, "the points");
  };
  if (!(by_more(problem, mirrored) > more_likely)) return;
  // The comparison is repeated with effects of inferred sizes, which may be larger than expected on either side.
  PointProblem here = problem, there = mirrored;
  infer_sizes(here), infer_sizes(there);
  if (!(by_more(std::move(here), std::move(there)) > more_likely)) return;
  problem = std::move(mirrored);
  findings.add<Code::latitude_of_other_sign>(", which is used");
  findings.add<Code::wrong_latitude>();
}

/// Drops outliers and names them in the findings. Sizes of effects are inferred first because an effect may explain apparent outliers.
void fit_good_points(PointProblem& problem, double outlier_level, kernel::Findings& findings) {
  const std::size_t points = problem.points.all.size();
  infer_sizes(problem);
  const std::vector<std::string> dropped = drop_bad_points(problem, outlier_level);
  kernel::add_dropped(findings, dropped, points, "points");
  if (!dropped.empty()) {
    fit_determined(problem);
    infer_sizes(problem);
  }
  if (problem.effects.size() == 0) return;
  const kernel::Parameters parameters = problem.parameters();
  const kernel::Information data = problem.information();
  kernel::doubt_improbable(
      findings, problem.effects,
      problem.effects.p_value(parameters, kernel::solve(data, parameters, "the points"), data.rows, 6 * dropped.size(), problem.coefficients));
}

/// Enlarges the noise until it explains the residuals; returns the factor.
double enlarge_noise(PointProblem& problem) {
  double scatter = 1, more = 2;
  for (int pass = 0; pass < 10 && more >= 1.01; ++pass) {
    const kernel::Solution s = fit(problem).solution();
    more = kernel::excess(s.chi2, s.degrees_of_freedom);
    problem.noise_factor *= more;
    scatter *= more;
  }
  return scatter;
}

/// Estimates jointly. Coefficients that the data do not determine become considered. Outliers are dropped point by point while their p-value is below
/// `outlier_level` divided by the number of points; if more than one in fifty would be dropped, all stay. An optional term (cubic, quadratic,
/// second-order thermal, g-sensitivity, by triad) is fixed at its starting value if it is not significant and does not improve the prediction of
/// omitted points (ten parts) beyond chance.
JointEstimate joint_estimate(PointProblem& problem, const CalibrationOptions& options) {
  JointEstimate out;
  hold_others(problem, options.terms);
  fit_under_priors(problem, options);
  fit_determined(problem);
  mirror_wrong_latitude(problem, out.findings);
  check_noise(out.findings, problem);
  Findings machine = wrong_machine(problem);  // before its points are dropped
  fit_good_points(problem, options.outlier_level, out.findings);
  out.scatter = enlarge_noise(problem);
  // Insignificant terms that are left out may exist within their uncertainty: they enter the others' covariance.
  const kernel::Parameters counted = problem.parameters(Priors::considered);
  const bool all = options.whole_unit.full || options.whole_unit.stepwise;
  if (options.terms.empty() && !all) out.tests = choose_terms(problem, options.significance);
  if (!out.tests.empty()) out.scatter *= enlarge_noise(problem);  // scatter of the points without the terms left out
  const kernel::Parameters parameters = problem.parameters();
  for (std::size_t k = 0; k < problem.role.size(); ++k)
    if (problem.role[k] == Role::fixed && counted.role[k] == Role::estimated) out.left_out.push_back(k);
  const Fit last = fit(problem);
  out.converged = last.converged;
  if (machine.empty()) machine = wrong_machine(problem);
  out.solution = last.solution();
  out.solution.covariance = kernel::solve(last.data, counted, "the points").covariance;
  out.solution.chi2 *= out.scatter * out.scatter;
  out.condition = kernel::condition_number(last.data, parameters);
  if (out.scatter > 1) out.findings.add<Code::points_scatter>(out.scatter);
  out.findings.append(machine);
  return out;
}

/// Throws Error if a scale is far from that of the declared unit.
void check_units(const PointProblem& problem) {
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

/// Sets coefficients and covariance for the readings from those for readings minus their center; the covariance may contain further parameters.
/// Coefficients that were not estimated keep their start; of these only terms that were left out have a covariance of their own. `constant` is the
/// part of the covariance that recurs for the same IMU; empty: zero.
void set_estimate(Calibration& calibration, const PointProblem& problem, const std::vector<std::size_t>& left_out, SensorModel model,
                  MatrixXd covariance, MatrixXd constant = {}) {
  for (std::size_t k = 0; k < problem.role.size(); ++k) {
    if (problem.role[k] == Role::estimated) continue;
    set_coefficient(model, problem.coefficients[k], coefficient_value(problem.start, problem.coefficients[k]));
    if (std::find(left_out.begin(), left_out.end(), k) != left_out.end()) continue;
    for (MatrixXd* const m : {&covariance, &constant})
      if (const auto i = static_cast<Index>(k); m->size() > 0) m->row(i).setZero(), m->col(i).setZero();
  }
  const auto change = [&](const SensorModel& m) { return of_shifted_readings(m, problem.center.head<3>(), problem.center.tail<3>()); };
  calibration.model = change(model);
  const Index n = std::ssize(problem.coefficients);
  covariance = covariance_after(change, problem.coefficients, covariance.topLeftCorner(n, n));
  std::vector<Index> kept;
  for (std::size_t k = 0; k < problem.role.size(); ++k) {
    const auto i = static_cast<Index>(k);
    if (problem.role[k] != Role::estimated && !(covariance(i, i) > 0)) continue;  // uncertain if it depends on an estimated one
    kept.push_back(i);
    calibration.estimated.push_back(problem.coefficients[k]);
  }
  calibration.covariance = covariance(kept, kept);
  if (constant.size() > 0)
    calibration.constant_covariance = limited_part(covariance_after(change, problem.coefficients, constant)(kept, kept), calibration.covariance);
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

  PointProblem problem(points, session, start, center);
  JointEstimate joint = joint_estimate(problem, options);
  check_units(problem);
  CalibrationResult result;
  Calibration& calibration = result.calibration;
  calibration.imu = session.imu.name;
  calibration.method = options.whole_unit.stepwise ? "whole-unit stepwise" : "whole-unit";
  calibration.frame = BodyFrame::rig;
  if (options.whole_unit.stepwise) {  // residuals and rig errors remain those of the joint fit because they describe the data
    const StepwiseEstimate steps = stepwise_estimate(problem, true);
    set_estimate(calibration, problem, {}, steps.model, steps.covariance * (joint.scatter * joint.scatter));
  } else {
    const kernel::Parameters counted = problem.parameters(Priors::considered);
    set_estimate(calibration, problem, joint.left_out, problem.model, joint.solution.covariance,
                 problem.effects.constant_part(counted, joint.solution.covariance, problem.coefficients));
  }
  calibration.quality = quality_of(problem, joint);
  check_chamber(joint.findings, problem);
  if (problem.effects.size() > 0)
    kernel::add_effects(calibration, joint.findings, problem.effects, joint.solution.covariance, 1e-3, problem.coefficients);
  if (options.effects && options.whole_unit.stepwise) joint.findings.add<Code::stepwise>();
  kernel::add_common_doubts(joint.findings, calibration, session.site);
  kernel::conclude(calibration, joint.findings);
  return result;
}

Prediction predict(const Session& procedure, const PredictionOptions& asked) {
  validate(procedure);
  expect_latitude(procedure);
  const NoiseModels noise = errors_at(procedure.file, [&] { return declared_noise(procedure.imu); });
  const double rate = procedure.recordings.empty() ? 1 : procedure.recordings.front().rate_hz.value_or(default_sample_rate);
  Vector6d variance;
  variance << Vector3d::Constant(noise.accel.N * noise.accel.N * rate), Vector3d::Constant(noise.gyro.N * noise.gyro.N * rate);
  const MachinePoints points = planned_points(procedure, variance);
  const Vector6d center = reading_center(points);
  PointProblem problem(points, procedure, starting_model(points, procedure, center), center);
  problem.ideal = true;
  for (MachinePoint& point : problem.points.all) {  // includes exactly known errors of the machines
    const Motion motion = problem.motion(point);
    point.raw << motion.force, motion.rate;
  }
  CalibrationOptions options;
  options.terms = asked.terms;
  options.effects = asked.effects;
  options.whole_unit.full = true;  // a term that is left out would still enter the covariance
  const JointEstimate joint = joint_estimate(problem, options);
  Calibration calibration;
  calibration.frame = BodyFrame::rig;
  set_estimate(calibration, problem, joint.left_out, problem.model, joint.solution.covariance);
  calibration.quality = quality_of(problem, joint);
  Prediction out = prediction_of(calibration);
  out.missed = shortfalls(out, asked.requirements);
  return out;
}

}  // namespace imulab::whole_unit
