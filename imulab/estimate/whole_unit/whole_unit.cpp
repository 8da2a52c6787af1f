#include "imulab/estimate/whole_unit/whole_unit.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/estimate/kernel/input.hpp"
#include "imulab/estimate/whole_unit/diagnosis.hpp"
#include "imulab/estimate/whole_unit/quality.hpp"
#include "imulab/estimate/whole_unit/selection.hpp"
#include "imulab/estimate/whole_unit/starting_model.hpp"
#include "imulab/estimate/whole_unit/stepwise.hpp"
#include "imulab/model/gauge.hpp"
#include "imulab/recording/validate.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace imulab::whole_unit {

using Eigen::Index;
using Eigen::MatrixXd;
using kernel::Role;

namespace {

/// Holds the coefficients that are not asked for at their starting values.
void hold_others(Problem& problem, const std::vector<CoefficientIndex>& terms) {
  const std::vector<CoefficientIndex> chosen = kernel::chosen_coefficients(terms, problem.coefficients, "whole-unit");
  for (std::size_t k = 0; k < problem.role.size(); ++k)
    if (std::find(chosen.begin(), chosen.end(), problem.coefficients[k]) == chosen.end()) problem.role[k] = Role::fixed;
}

/// Everything under its prior: from Dai's three steps where the machines did them, else from the linear model.
void fit_under_priors(Problem& problem, const CalibrationOptions& options) {
  if (options.terms.empty() && has_three_steps(problem)) try {
      problem.model = stepwise_estimate(problem, false).model;
    } catch (const Unsupported&) {  // too few rates for the steps are not too few for the joint estimate
    }
  fit(problem, Priors::all);
}

/// What the data determine, with the noise that the fitted slopes give.
void fit_determined(Problem& problem) {
  consider_undetermined(problem);
  fit(problem);
  problem.update_noise();
  fit(problem);
}

void check_noise(kernel::Findings& findings, const Problem& problem) {
  const Vector6d measured = problem.measured_noise();
  const auto check = [&](const char* name, const std::optional<double>& density, const Vector3d& variance) {
    if (density && *density > 0) kernel::check_declared_noise(findings, name, std::sqrt(variance.mean() * problem.points.interval_s) / *density);
  };
  check("accelerometers", problem.session->imu.accel_noise_density, measured.head<3>());
  check("gyros", problem.session->imu.gyro_noise_density, measured.tail<3>());
}

/// Residuals larger than noise and declarations explain, by chance less than once in a thousand: the noise is taken as that much larger.
double excess(const kernel::Solution& s) {
  if (s.degrees_of_freedom < 1 || chi_square_tail(s.chi2, s.degrees_of_freedom) > 1e-3) return 1;
  return std::sqrt(s.chi2 / s.degrees_of_freedom);
}

/// Enlarges the noise until the points scatter as it says: by how much.
double enlarge_noise(Problem& problem) {
  double scatter = 1;
  for (int pass = 0; pass < 10; ++pass) {
    const double more = excess(fit(problem).solution);
    problem.noise_factor *= more;
    scatter *= more;
    if (more < 1.01) break;
  }
  return scatter;
}

JointEstimate joint_estimate(Problem& problem, const CalibrationOptions& options) {
  JointEstimate out;
  hold_others(problem, options.terms);
  fit_under_priors(problem, options);
  fit_determined(problem);
  check_noise(out.findings, problem);
  std::string machine = wrong_machine(problem);  // before its points are dropped
  kernel::add_dropped(out.findings, drop_bad_points(problem, options.outlier_level), problem.points.all.size());
  fit_determined(problem);
  out.scatter = enlarge_noise(problem);
  // Terms that are left out for want of significance may still be there, within their uncertainty: they count in the others' covariance.
  const kernel::Parameters counted = problem.parameters(Priors::considered);
  if (options.terms.empty() && !options.whole_unit.full && !options.whole_unit.stepwise) out.tests = choose_terms(problem, options.significance);
  const kernel::Parameters parameters = problem.parameters();
  const Fit last = fit(problem);
  if (!last.converged) out.findings.doubt("the fit did not converge");
  if (machine.empty()) machine = wrong_machine(problem);
  out.solution = last.solution;
  out.solution.covariance = kernel::solve(last.data, counted, "the points").covariance;
  out.solution.chi2 *= out.scatter * out.scatter;
  out.condition = kernel::condition_number(last.data, parameters);
  if (out.scatter > 1) {
    const std::string what = fmt::format("the points scatter {:.2f} times as much as noise and declared errors explain", out.scatter);
    out.findings.warn(what + "; the uncertainties are enlarged by that");
    out.findings.doubt(what);
  }
  if (!machine.empty()) out.findings.warn(machine), out.findings.doubt("a machine is not as declared");
  return out;
}

/// Throws Error where a scale came out far from that of the declared unit.
void check_units(const Problem& problem) {
  for (std::size_t k = 0; k < problem.role.size(); ++k) {
    const Coefficient& c = coefficient(problem.coefficients[k]);
    const TriadModel& m = c.triad == Triad::accel ? problem.model.accel : problem.model.gyro;
    if (problem.role[k] != Role::estimated || c.term != Term::matrix || c.row != c.column || m.raw_unit == "count") continue;
    const double scale = m.matrix(c.row, c.row);
    if (scale > 0.5 && scale < 2) continue;
    const std::string_view unit = kernel::mistaken_unit(c.triad, scale);
    throw Error(fmt::format("{}: {} comes out as {:.4g} for readings in {}{}; check the unit, the columns and the machines' numbers",
                            problem.session->file, c.name, scale, m.raw_unit, unit.empty() ? "" : fmt::format(", as if they were in {}", unit)));
  }
}

/// Coefficients and covariance of the readings, from those of readings less their center. What is not estimated keeps its starting value.
void set_estimate(Calibration& calibration, const Problem& problem, SensorModel model, MatrixXd covariance) {
  for (std::size_t k = 0; k < problem.role.size(); ++k) {
    if (problem.role[k] == Role::estimated) continue;
    set_coefficient(model, problem.coefficients[k], coefficient_value(problem.start, problem.coefficients[k]));
    covariance.row(static_cast<Index>(k)).setZero(), covariance.col(static_cast<Index>(k)).setZero();
  }
  const auto change = [&](const SensorModel& m) { return uncentered(m, problem.center); };
  calibration.model = change(model);
  covariance = covariance_after(change, problem.coefficients, covariance);
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
  if (!session.site.latitude)
    throw Error(session.file + ": the site has no latitude; expected one, as the gyros measure the Earth's rate on every machine");
  const Points points = points_of(input.recordings, session);
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
    set_estimate(calibration, problem, steps.model, steps.covariance * (joint.scatter * joint.scatter));
  } else {
    const Index n = std::ssize(problem.coefficients);
    set_estimate(calibration, problem, problem.model, joint.solution.covariance.topLeftCorner(n, n));
  }
  calibration.quality = quality_of(problem, joint);
  check_chamber(joint.findings, problem);
  kernel::add_common_doubts(joint.findings, calibration, session.site);
  kernel::conclude(calibration, joint.findings);
  return result;
}

}  // namespace imulab::whole_unit
