#include "imulab/estimate/whole_unit.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/core/units.hpp"
#include "imulab/estimate/common.hpp"
#include "imulab/estimate/whole_unit_course.hpp"
#include "imulab/estimate/whole_unit_diagnosis.hpp"
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
      measured += (slope.cwiseAbs2() * p.variance).segment<3>(static_cast<Index>(3 * triad)).mean() / static_cast<double>(problem.points().points.size());
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
      throw Error(fmt::format("{}: {} comes out as {:.4g} where readings in {} were declared: are the unit, the columns and the machines' numbers right?",
                              problem.session().file, c.name, scale, m.raw_unit));
  }
}

/// Coefficients and covariance of readings, not of readings less their centre.
void set_estimate(Calibration& calibration, const WholeUnitProblem& problem, SensorModel model, const SensorModel& start, const std::vector<Part>& parts, MatrixXd covariance) {
  const auto& indices = problem.coefficients();
  const auto n = static_cast<Index>(indices.size());
  MatrixXd transfer = MatrixXd::Zero(n, n);  // linear: what each coefficient alone becomes
  for (Index k = 0; k < n; ++k) {
    SensorModel one;
    one.accel.matrix.setZero(), one.gyro.matrix.setZero();
    set_coefficient(one, indices[static_cast<std::size_t>(k)], 1);
    const SensorModel moved = uncentred(one, problem.center());
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
  calibration.model = uncentred(model, problem.center());
  calibration.covariance = covariance(at, at);
}

/// Why a coefficient stayed open, where counting tells.
std::string open_reason(const WholeUnitProblem& problem, const Coefficient& c) {
  const int order = c.term == Term::quadratic ? 2 : c.term == Term::cubic ? 3 : 0;
  if (order == 0) return "";
  std::vector<double> levels;
  for (const WholeUnitPoint& p : problem.points().points) {
    const Motion m = problem.motion(p);
    const double level = c.triad == Triad::accel ? m.force[c.row] : m.rate[c.row], same = c.triad == Triad::accel ? 0.05 * unit::g : 0.1 * unit::deg;
    if (std::none_of(levels.begin(), levels.end(), [&](double l) { return std::abs(l - level) < same; })) levels.push_back(level);
  }
  return fmt::format(" ({} different {} along {}, at least {} over the range of use are needed)", levels.size(),
                     c.triad == Triad::accel ? "accelerations" : "rates", "xyz"[c.row], order + 2);
}

std::vector<FitResidual> fit_residuals(const WholeUnitProblem& problem) {
  std::vector<FitResidual> out;
  double full_scale[2] = {0, 0};
  for (const WholeUnitPoint& p : problem.points().points) {
    const Motion m = problem.motion(p);
    full_scale[0] = std::max(full_scale[0], m.force.cwiseAbs().maxCoeff());
    full_scale[1] = std::max(full_scale[1], m.rate.cwiseAbs().maxCoeff());
  }
  for (int channel = 0; channel < 6; ++channel) {
    const std::size_t triad = channel < 3 ? 0 : 1;
    FitResidual r{fmt::format("{}.{}", triad == 0 ? "accel" : "gyro", "xyz"[channel % 3]), 0, 0, full_scale[triad]};
    double n = 0;
    for (const WholeUnitPoint& p : problem.points().points) {
      if (problem.kind(p) == RigKind::chamber) continue;
      const double e = problem.equations(p).residual[channel];
      r.rms += e * e, r.largest = std::max(r.largest, std::abs(e)), n += 1;
    }
    if (n == 0) continue;
    r.rms = std::sqrt(r.rms / n);
    out.push_back(r);
  }
  return out;
}

/// Residuals larger than noise and declarations explain, by chance less than once in a thousand: the noise is taken as that much larger.
double excess(const Solution& s) {
  if (s.degrees_of_freedom < 1 || chi_square_tail(s.chi2, s.degrees_of_freedom) > 1e-3) return 1;
  return std::sqrt(s.chi2 / s.degrees_of_freedom);
}

std::vector<RigErrorEstimate> estimated_errors(const WholeUnitProblem& problem, const Solution& s) {
  std::vector<RigErrorEstimate> out;
  const auto first = static_cast<Index>(problem.coefficients().size());
  for (std::size_t k = 0; k < problem.common().size(); ++k) {
    const CommonError& error = problem.common()[k];
    const Index i = first + static_cast<Index>(k);
    if (error.sigma > 0) out.push_back({error.name(), error.sigma, error.value, std::sqrt(s.covariance(i, i))});
  }
  return out;
}

/// Radii one by one, where the data know them twice as well as their declaration; the many small angles in one line.
void note_rig_errors(Quality& quality) {
  std::size_t angles = 0;
  double square = 0;
  for (const RigErrorEstimate& e : quality.rig_errors) {
    if (e.name == "gravity" || e.uncertainty > 0.5 * e.declared_sigma) continue;
    const bool radius = e.name.find("radius") != std::string::npos, rate = e.name.ends_with("rate");
    if (!radius && !rate) {
      ++angles, square += e.value * e.value;
      continue;
    }
    const double unit = radius ? 1e-3 : unit::ppm;
    quality.notes.push_back(fmt::format("{}: {:+.3g} +/- {:.2g} {} from its declaration (sigma {:.3g})", e.name, e.value / unit, e.uncertainty / unit,
                                        radius ? "mm" : "ppm", e.declared_sigma / unit));
  }
  if (angles > 0)
    quality.notes.push_back(fmt::format("{} errors of mounting and levelling were found along, {:.3g} arcsec RMS", angles, std::sqrt(square / static_cast<double>(angles)) / unit::arcsec));
}

void add_notes(Quality& quality, const WholeUnitProblem& problem) {
  std::size_t of[3] = {0, 0, 0};
  for (const WholeUnitPoint& p : problem.points().points) ++of[problem.kind(p) == RigKind::chamber ? 0 : problem.kind(p) == RigKind::rate_table ? 1 : 2];
  quality.notes.push_back(fmt::format("{} points were used: {} in the chamber, {} on the rate table, {} on the centrifuge", problem.points().points.size(), of[0], of[1], of[2]));
  const auto text = [&](std::size_t first, double unit, const char* name) {
    const auto& r = quality.fit_residuals;
    const auto percent = [&](std::size_t k) { return 100 * r[k].rms / r[k].full_scale; };
    const double largest = std::max({r[first].largest / r[first].full_scale, r[first + 1].largest / r[first].full_scale, r[first + 2].largest / r[first].full_scale});
    quality.notes.push_back(fmt::format("fit residual, x y z: {:.2g}, {:.2g}, {:.2g} % RMS of the full scale of {:.4g} {} (largest {:.2g} %)", percent(first), percent(first + 1),
                                        percent(first + 2), r[first].full_scale / unit, name, 100 * largest));
  };
  if (quality.fit_residuals.size() == 6) text(0, unit::g, "g"), text(3, unit::deg, "deg/s");
  note_rig_errors(quality);
}

/// What became of a session: the problem where the fit stands, and how it came there.
struct Outcome {
  std::vector<Part> parts;
  Solution solution;   ///< chi2 against the noise as measured
  double scatter = 1;  ///< by which the uncertainties are enlarged
  std::vector<TermTest> tests;
  std::vector<std::string> dropped, wrong_machines, warnings;
};

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
Outcome estimate(WholeUnitProblem& problem, const WholeUnitPrior& prior, const WholeUnitOptions& options) {
  Outcome out;
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

void add_all(std::vector<std::string>& to, const std::vector<std::string>& more) { to.insert(to.end(), more.begin(), more.end()); }

Quality quality_of(const WholeUnitProblem& problem, const Outcome& outcome) {
  Quality quality;
  const WholeUnitPoints& points = problem.points();
  const Solution& solution = outcome.solution;
  quality.term_tests = outcome.tests;
  quality.chi2_per_dof = solution.chi2 / std::max(1.0, solution.degrees_of_freedom);
  quality.degrees_of_freedom = static_cast<int>(std::lround(solution.degrees_of_freedom));
  quality.condition = solution.condition;
  add_all(quality.warnings, points.warnings);
  add_all(quality.warnings, outcome.warnings);
  for (std::size_t k = 0; k < outcome.parts.size(); ++k) {
    if (outcome.parts[k] != Part::weak) continue;
    const Coefficient& c = coefficient(problem.coefficients()[k]);
    quality.unobservable.emplace_back(c.name);
    if (const std::string reason = open_reason(problem, c); !reason.empty()) quality.warnings.push_back(std::string(c.name) + " is not determined" + reason);
  }
  for (const std::string& name : outcome.dropped) quality.warnings.push_back("dropped as an outlier: " + name);
  add_all(quality.warnings, outcome.wrong_machines);
  if (outcome.scatter > 1)
    quality.warnings.push_back(
        fmt::format("the points scatter {:.2f} times as much as noise and declared errors explain; the uncertainties are enlarged by that", outcome.scatter));
  quality.fit_residuals = fit_residuals(problem);
  const double relative = problem.session().site.gravity_sigma() / problem.session().site.gravity();
  quality.sources.push_back({"gravity", relative, fmt::format("g is known to {:.3g} ppm", relative / unit::ppm)});
  quality.rig_errors = estimated_errors(problem, solution);
  add_notes(quality, problem);
  return quality;
}

}  // namespace

Calibration calibrate_whole_unit(const std::vector<Recording>& recordings, const Session& session, const WholeUnitOptions& options) {
  if (options.stepwise && !options.terms.empty()) throw Error("stepwise: Dai's steps estimate all coefficients; terms cannot be chosen");
  if (!session.site.latitude) throw Error(session.file + ": [site]: latitude_deg was expected: the gyros read the Earth's rate on every machine");
  const WholeUnitPoints points = whole_unit_points(recordings, session);
  const Vector6d centre = reading_centre(points);
  const SensorModel start = start_model(points, session, centre);
  check_mounts(points, session, start, centre);

  WholeUnitProblem problem(points, session, start, centre);
  const Outcome outcome = estimate(problem, WholeUnitPrior(problem, start), options);
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
  calibration.quality = quality_of(problem, outcome);
  const std::vector<std::string> chamber = wrong_chamber(problem);
  add_all(calibration.quality.warnings, chamber);
  std::vector<std::string> doubts = common_doubts(calibration, session.site, outcome.dropped.size(), points.points.size());
  if (outcome.scatter > 1) doubts.push_back(fmt::format("the points scatter {:.2f} times as much as noise and declared errors explain", outcome.scatter));
  if (!outcome.wrong_machines.empty()) doubts.push_back("a machine is not as declared");
  if (!chamber.empty()) doubts.push_back("the chamber's points do not settle or do not repeat");
  conclude(calibration, doubts);
  return calibration;
}

}  // namespace imulab
