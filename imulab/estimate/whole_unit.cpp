#include "imulab/estimate/whole_unit.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/core/units.hpp"
#include "imulab/estimate/common.hpp"
#include "imulab/estimate/whole_unit_course.hpp"
#include "imulab/estimate/whole_unit_diagnosis.hpp"
#include "imulab/estimate/whole_unit_quality.hpp"
#include "imulab/estimate/whole_unit_start.hpp"
#include "imulab/estimate/whole_unit_stepwise.hpp"
#include "imulab/model/compensation_derivatives.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace imulab {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

const Coefficient& coefficient(int index) { return coefficient_table()[static_cast<std::size_t>(index)]; }

/// Declared densities that the points' own scatter contradicts.
void compare_noise(const WholeUnitProblem& problem, std::vector<std::string>& warnings) {
  for (std::size_t triad = 0; triad < 2; ++triad) {
    const auto& density = triad == 0 ? problem.session().imu.accel_noise_density : problem.session().imu.gyro_noise_density;
    if (!density || !(*density > 0)) continue;
    double measured = 0;
    for (const WholeUnitPoint& p : problem.points().points) {
      const auto slope = compensation_derivatives(problem.model(), problem.sample(p)).raw;
      measured +=
          (slope.cwiseAbs2() * p.variance).segment<3>(static_cast<Index>(3 * triad)).mean() / static_cast<double>(problem.points().points.size());
    }
    const double ratio = std::sqrt(measured * problem.points().interval_s) / *density;
    if (ratio > 1.5 || ratio < 1 / 1.5)
      warnings.push_back(fmt::format("the {} noise within points is {:.2g} times the declared density; the declared one sets the weights",
                                     triad == 0 ? "accelerometers'" : "gyros'", ratio));
  }
}

/// All candidates, or those asked for.
std::vector<Part> asked_parts(const WholeUnitProblem& problem, const std::vector<int>& terms) {
  const auto& indices = problem.coefficients();
  std::vector<Part> parts(indices.size(), Part::estimated);
  if (terms.empty()) return parts;
  const std::vector<int> chosen = choose_terms(terms, indices, "whole-unit");
  for (std::size_t k = 0; k < indices.size(); ++k)
    if (std::find(chosen.begin(), chosen.end(), indices[k]) == chosen.end()) parts[k] = Part::absent;
  return parts;
}

/// Readings whose scales came out far from their declared unit.
void check_units(const WholeUnitProblem& problem, const std::vector<Part>& parts) {
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const Coefficient& c = coefficient(problem.coefficients()[k]);
    const TriadModel& m = c.triad == Triad::accel ? problem.model().accel : problem.model().gyro;
    if (parts[k] != Part::estimated || c.term != Term::matrix || c.row != c.column || m.raw_unit == "count") continue;
    if (const double scale = m.matrix(c.row, c.row); !(scale > 0.5 && scale < 2))
      throw Error(
          fmt::format("{}: {} comes out as {:.4g} where readings in {} were declared: are the unit, the columns and the machines' numbers right?",
                      problem.session().file, c.name, scale, m.raw_unit));
  }
}

/// Coefficients and covariance of readings, not of readings less their center.
void set_estimate(Calibration& calibration, const WholeUnitProblem& problem, SensorModel model, const SensorModel& start,
                  const std::vector<Part>& parts, MatrixXd covariance) {
  const auto& indices = problem.coefficients();
  const auto n = static_cast<Index>(indices.size());
  MatrixXd transfer = MatrixXd::Zero(n, n);  // linear: what each coefficient alone becomes
  for (Index k = 0; k < n; ++k) {
    SensorModel one;
    one.accel.matrix.setZero(), one.gyro.matrix.setZero();
    set_coefficient(one, indices[static_cast<std::size_t>(k)], 1);
    const SensorModel moved = uncentered(one, problem.center());
    for (Index i = 0; i < n; ++i) transfer(i, k) = coefficient_value(moved, indices[static_cast<std::size_t>(i)]);
  }
  std::vector<char> kept(indices.size());
  for (std::size_t k = 0; k < indices.size(); ++k) {
    kept[k] = parts[k] == Part::estimated;
    if (kept[k]) continue;
    set_coefficient(model, indices[k], coefficient_value(start, indices[k]));
    covariance.row(static_cast<Index>(k)).setZero(), covariance.col(static_cast<Index>(k)).setZero();
  }
  covariance = (transfer * covariance * transfer.transpose()).eval();
  std::vector<Index> at;
  for (Index i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (!kept[k] && !(covariance(i, i) > 0)) continue;
    at.push_back(i);
    calibration.estimated.push_back(indices[k]);
  }
  calibration.model = uncentered(model, problem.center());
  calibration.covariance = covariance(at, at);
}

/// Residuals larger than noise and declarations explain, by chance less than once in a thousand: the noise is taken as that much larger.
double excess(const Solution& s) {
  if (s.degrees_of_freedom < 1 || chi_square_tail(s.chi2, s.degrees_of_freedom) > 1e-3) return 1;
  return std::sqrt(s.chi2 / s.degrees_of_freedom);
}

/// From Dai's three steps where there are all three, else from what the priors allow.
void start(WholeUnitProblem& problem, const WholeUnitPrior& prior, const WholeUnitOptions& options, std::vector<Part> parts) {
  if (options.terms.empty() && has_three_steps(problem)) try {
      problem.set_model(stepwise_estimate(problem, false).model);
    } catch (const Unsupported&) {  // too few rates for the steps are not too few for the joint estimate
    }
  std::replace(parts.begin(), parts.end(), Part::estimated, Part::weak);
  converge(problem, prior, parts, Weak::free);
}

/// What the data determine, and the fit of it, with the noise that the fitted slopes give.
WholeUnitFit fit_determined(WholeUnitProblem& problem, const WholeUnitPrior& prior, std::vector<Part>& parts) {
  parts = determined(problem, prior, parts);
  converge(problem, prior, parts);
  problem.measure_noise();
  return converge(problem, prior, parts);
}

/// Takes the noise as so much larger that the points scatter as they should: by how much.
double enlarge_to_scatter(WholeUnitProblem& problem, const WholeUnitPrior& prior, const std::vector<Part>& parts) {
  double scatter = 1;
  for (int pass = 0; pass < 10; ++pass) {
    const double more = excess(converge(problem, prior, parts).solution);
    problem.enlarge_noise(more);
    scatter *= more;
    if (more < 1.01) break;
  }
  return scatter;
}

/// The joint estimate.
WholeUnitOutcome estimate(WholeUnitProblem& problem, const WholeUnitPrior& prior, const WholeUnitOptions& options) {
  WholeUnitOutcome out;
  out.parts = asked_parts(problem, options.terms);
  start(problem, prior, options, out.parts);
  fit_determined(problem, prior, out.parts);
  compare_noise(problem, out.warnings);
  out.wrong_machines = wrong_machines(problem, prior, out.parts);  // before its points are dropped
  out.dropped = drop_outliers(problem, prior, out.parts, options.outlier_level);
  fit_determined(problem, prior, out.parts);
  out.scatter = enlarge_to_scatter(problem, prior, out.parts);
  // What is left out for want of significance may still be there, within its uncertainty: it counts in the others' covariance.
  const std::vector<Part> all = out.parts;
  if (options.terms.empty() && !options.full && !options.stepwise) out.tests = choose_orders(problem, prior, out.parts);
  const WholeUnitFit fit = converge(problem, prior, out.parts);
  if (!fit.converged) out.warnings.push_back("the fit did not settle");
  if (out.wrong_machines.empty()) out.wrong_machines = wrong_machines(problem, prior, out.parts);
  out.solution = fit.solution;
  out.solution.covariance = covariance(fit, problem, prior, all);
  out.solution.chi2 *= out.scatter * out.scatter;
  return out;
}

}  // namespace

Calibration calibrate_whole_unit(const std::vector<Recording>& recordings, const Session& session, const WholeUnitOptions& options) {
  if (options.stepwise && !options.terms.empty()) throw Error("stepwise: Dai's steps estimate all coefficients; terms cannot be chosen");
  if (!session.site.latitude) throw Error(session.file + ": [site]: latitude_deg was expected: the gyros read the Earth's rate on every machine");
  const WholeUnitPoints points = whole_unit_points(recordings, session);
  const Vector6d center = reading_center(points);
  const SensorModel start = start_model(points, session, center);
  check_mounts(points, session, start, center);

  WholeUnitProblem problem(points, session, start, center);
  const WholeUnitOutcome outcome = estimate(problem, WholeUnitPrior(problem, start), options);
  check_units(problem, outcome.parts);
  const auto n = static_cast<Index>(problem.coefficients().size());
  Calibration calibration;
  calibration.imu = session.imu.name;
  calibration.method = options.stepwise ? "whole-unit stepwise" : "whole-unit";
  calibration.frame = "rig";
  if (options.stepwise) {  // residuals and rig errors stay those of the joint fit: they are the data's, not the estimate's
    const StepwiseEstimate steps = stepwise_estimate(problem, true);
    set_estimate(calibration, problem, steps.model, start, outcome.parts, steps.covariance * (outcome.scatter * outcome.scatter));
  } else {
    set_estimate(calibration, problem, problem.model(), start, outcome.parts, outcome.solution.covariance.topLeftCorner(n, n));
  }
  calibration.quality = whole_unit_quality(problem, outcome);
  const std::vector<std::string> chamber = wrong_chamber(problem);
  calibration.quality.warnings.insert(calibration.quality.warnings.end(), chamber.begin(), chamber.end());
  std::vector<std::string> doubts = common_doubts(calibration, session.site, outcome.dropped.size(), points.points.size());
  if (outcome.scatter > 1)
    doubts.push_back(fmt::format("the points scatter {:.2f} times as much as noise and declared errors explain", outcome.scatter));
  if (!outcome.wrong_machines.empty()) doubts.push_back("a machine is not as declared");
  if (!chamber.empty()) doubts.push_back("the chamber's points do not settle or do not repeat");
  conclude(calibration, doubts);
  return calibration;
}

}  // namespace imulab
