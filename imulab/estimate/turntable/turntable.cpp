#include "imulab/estimate/turntable/turntable.hpp"

#include "imulab/core/decomposition.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/earth.hpp"
#include "imulab/error.hpp"
#include "imulab/estimate/kernel/effect_findings.hpp"
#include "imulab/estimate/kernel/findings.hpp"
#include "imulab/estimate/kernel/input.hpp"
#include "imulab/estimate/kernel/plausibility.hpp"
#include "imulab/estimate/kernel/prior.hpp"
#include "imulab/estimate/kernel/site.hpp"
#include "imulab/estimate/kernel/terms.hpp"
#include "imulab/estimate/turntable/explanation.hpp"
#include "imulab/estimate/turntable/fit.hpp"
#include "imulab/units.hpp"

#include <Eigen/LU>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace imulab::turntable {

using Eigen::Index;
using Eigen::VectorXd;
using kernel::Findings;

namespace {

/// The declarations, observations and estimates of a triad.
struct TriadView {
  Triad triad;
  std::string_view sensors;
  const std::string& unit;
  const std::optional<double>& declared_density;
  const Vector3d& density;
  const Matrix3d& matrix;

  /// Returns the mean scale of readings in SI; absent for counts.
  std::optional<double> scale() const { return unit == "count" ? std::nullopt : std::optional(std::cbrt(std::abs(matrix.determinant()))); }
};

std::array<TriadView, 2> triads(const TableProblem& problem, const SensorModel& model) {
  const TableObservations& seen = problem.seen;
  const ImuDeclaration& imu = problem.imu;
  return {{{Triad::accel, "accelerometers", seen.accel_unit, imu.accel_noise_density, seen.accel_density, model.accel.matrix},
           {Triad::gyro, "gyros", seen.gyro_unit, imu.gyro_noise_density, seen.gyro_density, model.gyro.matrix}}};
}

/// Throws Error if a declared unit was mistaken for another.
void expect_units(const TableProblem& problem, const SensorModel& model) {
  for (const TriadView& view : triads(problem, model))
    if (const std::string_view looks = view.scale() ? kernel::mistaken_unit(view.triad, *view.scale()) : ""; !looks.empty())
      throw Error(fmt::format("{}: the table moved {:.3g} times as much as the readings show; they look like {}; correct their unit",
                              to_string(view.triad), *view.scale(), looks));
}

/// Throws Unsupported if a scale differs by more than 20 % from its declared unit.
void expect_scales(const Calibration& calibration, const Recording& recording) {
  for (const Triad triad : {Triad::accel, Triad::gyro}) {
    const TriadModel& model = triad_model(calibration.model, triad);
    if (model.raw_unit == "count") continue;
    if (const std::string wrong = kernel::scale_contradiction(triad, model.matrix, recording); !wrong.empty())
      throw Unsupported(fmt::format("{}: {}", recording.name, wrong));
  }
}

void check_noise(Findings& findings, const TableProblem& problem, const SensorModel& model) {
  for (const TriadView& view : triads(problem, model))
    if (view.declared_density && view.density.norm() > 0)
      kernel::check_declared_noise(findings, view.sensors, view.density.norm() / std::sqrt(raw_density(*view.declared_density, view.matrix).trace()));
}

/// Returns the offset of a sensor from its intended zero: for counts in offset binary, half of their range, a power of two.
Vector3d sensor_offset(const TriadModel& triad, std::string_view unit) {
  if (unit != "count") return triad.offset;
  Vector3d zero = -triad.matrix.inverse() * triad.offset;
  constexpr double least = 128;  // half the range of eight bits
  for (double& z : zero)
    if (const double middle = std::exp2(std::round(std::log2(std::max(z, 1.0)))); middle >= least && std::abs(z - middle) < z) z -= middle;
  return triad.matrix * zero;
}

/// Returns Wald's tests of the estimated optional terms, for the report only.
std::vector<TermTest> tests_of_terms(const Fit& fit, double significance) {
  const Estimator::Uncertainty uncertainty = fit.estimator.uncertainty(fit.model);
  const VectorXd values = coefficient_values(fit.model, uncertainty.stated);
  const VectorXd prior = fit.estimator.prior_sigma(fit.model, uncertainty.stated);
  std::vector<TermTest> tests;
  for (const char* term : {"gyro.g_sensitivity", "accel.quadratic", "accel.cubic", "gyro.quadratic", "gyro.cubic"}) {
    const std::vector<CoefficientIndex> of_term = select_coefficients(term);
    std::vector<Index> members;
    for (Index i = 0; i < values.size(); ++i)
      if (const CoefficientIndex index = uncertainty.stated[static_cast<std::size_t>(i)];
          contains(of_term, index) && !contains(uncertainty.considered, index))
        members.push_back(i);
    if (members.empty()) continue;
    const Eigen::MatrixXd covariance = uncertainty.covariance(members, members);
    tests.push_back(fit.options.optional ? kernel::wald_without_prior(term, values(members), covariance, prior(members), significance)
                                         : kernel::wald(term, values(members), covariance, significance));
  }
  return tests;
}

/// Doubts results with many outliers: more than a tenth of the holds or turns may follow a change of the IMU, which then has two calibrations.
void doubt_many_dropped(Findings& findings, const Fit& fit) {
  const TableMotion& motion = fit.problem->motion;
  std::array<std::size_t, 2> all{}, dropped{};
  for (std::size_t k = 0; k < motion.parts(); ++k) ++all[motion.is_hold(k)];
  for (const std::size_t k : fit.options.left_out) ++dropped[motion.is_hold(k)];
  constexpr std::size_t least = 3;
  for (const std::size_t kind : {1u, 0u})
    if (dropped[kind] >= least && 10 * dropped[kind] > all[kind])
      findings.add<Code::unit_changed>(dropped[kind], all[kind], kind == 1 ? "holds" : "turns");
}

/// Compares the residuals with the declared noise and table.
void judge_residuals(Findings& findings, const Fit& fit, const Fit& enlarged, const std::string& worst, bool by_size) {
  const int degrees_of_freedom = fit.estimator.degrees_of_freedom();
  if (degrees_of_freedom < 1) return;
  const double ratio = std::sqrt(fit.chi2 / degrees_of_freedom);
  if (by_size || fit.log_probability() < std::log(unlikely)) {
    findings.add<Code::residuals_enlarge>(ratio, enlarged.options.enlarged.accel, enlarged.options.enlarged.gyro, enlarged.options.enlarged.table,
                                          worst.empty() ? "" : "; most of all " + worst);
    findings.add<Code::residuals_exceed>();
  } else if (chi_square_tail(fit.chi2, degrees_of_freedom) > 1 - unlikely) {
    findings.add<Code::residuals_below_declaration>(ratio);
  } else if (const Enlargement& by = enlarged.options.enlarged; std::max({by.accel, by.gyro, by.table}) > 1.2) {
    findings.add<Code::likelier_noise>(by.accel, by.gyro, by.table);
  }
}

/// Returns the observed properties of the unit that indicate its grade.
kernel::SeenOfUnit seen_of(const TableProblem& problem, const SensorModel& model) {
  return kernel::seen_of_axes(kernel::output_sigma(model.accel.matrix, problem.seen.accel_density),
                              kernel::output_sigma(model.gyro.matrix, problem.seen.gyro_density), sensor_offset(model.accel, problem.seen.accel_unit),
                              sensor_offset(model.gyro, problem.seen.gyro_unit));
}

/// Adds the effects with values and uncertainties, and the causes of contradictions for the verdict.
void add_effects(Calibration& calibration, Findings& findings, const Fit& last) {
  kernel::Effects effects = last.options.effects.table;
  effects.correct(last.estimator.effects(last.readings) - effects.value());
  const Eigen::MatrixXd joint = joint_covariance(last, calibration.estimated, calibration.covariance);
  kernel::add_effects(calibration, findings, effects, joint, unlikely, calibration.estimated);
  kernel::Parameters parameters(joint.rows());
  parameters.sigma << last.estimator.prior_sigma(last.model, calibration.estimated), effects.sigma();
  calibration.constant_covariance = limited_part(effects.constant_part(parameters, joint, calibration.estimated), calibration.covariance);
  if (const std::optional<UnitChange>& change = last.options.effects.change) {
    const std::vector<Step>& steps = last.problem->seen.parts.steps;
    const Effect& effect = *change->effect;
    VectorXd by = VectorXd::Zero(3);
    for (const kernel::EffectGroup& g : effects.groups())
      if (g.effect == &effect) by = effects.value().segment(g.first, g.size) / effect.unit;
    findings.add<Code::changed_on_table>(effect.words, steps[change->step - 1].end);
    findings.add<Code::change_on_table>(effect.words, by[0], by[1], by[2], effect.unit_name, step_name(steps[change->step - 1], change->step - 1),
                                        step_name(steps[change->step], change->step), effect.advice);
  }
}

/// Returns the options of a fit with all optional terms under their priors.
EstimatorOptions all_terms(const Fit& free) {
  return with_optional_terms(free.options, kernel::of_likeliest_grade(free.problem->imu, seen_of(*free.problem, free.model)));
}

/// Returns the fit with all optional terms, and explanations of the readings beyond the priors. `is_right`: the steps are correct.
Explained explanation_of(const Fit& free, const kernel::EffectSizes& sizes, const CalibrationOptions& options, bool is_right) {
  EstimatorOptions all = options.terms.empty() ? all_terms(free) : free.options;
  all.all_optional = true;
  Explained out{fit(*free.problem, all), {}, {}, false};
  if (is_right)
    out = explained(out.fit, sizes, options.outlier_level);
  else
    out.fit = with_inferred_sizes(out.fit);
  all = out.fit.options;
  all.all_optional = false;
  out.fit = fit(*free.problem, all);
  return out;
}

/// Returns model, covariance and residuals of a fit, without the second-order bias.
Calibration calibration_of(const Fit& fit) {
  const TableProblem& problem = *fit.problem;
  Calibration calibration;
  calibration.imu = problem.imu.name;
  calibration.method = "turntable";
  calibration.frame = BodyFrame::rig;
  calibration.model = fit.model;
  calibration.model.accel.raw_unit = problem.seen.accel_unit;
  calibration.model.gyro.raw_unit = problem.seen.gyro_unit;
  const Estimator::Uncertainty uncertainty = fit.estimator.uncertainty(fit.model);
  if (uncertainty.stated.size() == uncertainty.considered.size())
    throw Unsupported("the steps determine no coefficient; holds with each axis up and down, and turns about each axis, are needed");
  calibration.estimated = uncertainty.stated;
  const Estimator::SecondOrder second = fit.estimator.second_order(calibration.model, calibration.estimated);
  for (Index i = 0; i < second.bias.size(); ++i) {
    const CoefficientIndex index = calibration.estimated[static_cast<std::size_t>(i)];
    set_coefficient(calibration.model, index, coefficient_value(calibration.model, index) - second.bias[i]);
  }
  calibration.covariance = uncertainty.covariance + second.covariance;
  Quality& quality = calibration.quality;
  for (const CoefficientIndex index : uncertainty.undetermined) quality.unobservable.emplace_back(coefficient(index).name);
  for (const CoefficientIndex index : uncertainty.considered) quality.considered.emplace_back(coefficient(index).name);
  quality.degrees_of_freedom = fit.estimator.degrees_of_freedom();
  quality.condition = fit.estimator.condition();
  quality.converged = fit.converged;
  quality.chi2_per_dof = fit.chi2 / std::max(1, quality.degrees_of_freedom);
  quality.sources.push_back(kernel::gravity_source(problem.site));
  const std::vector<double> residuals = fit.estimator.part_residuals(fit.readings);
  const std::vector<std::size_t>& left_out = fit.options.left_out;
  for (std::size_t k = 0; k < residuals.size(); ++k)
    (problem.motion.is_hold(k) ? quality.rests : quality.rotations)
        .push_back({problem.motion.begin(k), problem.motion.end(k), residuals[k], std::find(left_out.begin(), left_out.end(), k) == left_out.end()});
  return calibration;
}

}  // namespace

Calibration calibrate(const TableObservations& seen, const RigDeclaration& rig, const ImuDeclaration& imu, const Site& site,
                      const CalibrationOptions& options) {
  if (!seen.noise_measured && !(imu.accel_noise_density && imu.gyro_noise_density))
    throw Unsupported("the holds are too short to measure the sensors' noise; declare the noise densities of accelerometers and gyros");
  const TableProblem problem(seen, rig, imu, options.effects ? kernel::beside_effects(site) : site);
  EstimatorOptions asked;
  asked.terms = chosen_coefficients(options.terms, seen.accel_unit, seen.gyro_unit);
  asked.bias_while_turning = options.turntable.bias_while_turning;
  Fit free = fit(problem, asked);
  expect_units(problem, free.model);
  Session declared;
  declared.imu = imu, declared.site = site;
  const kernel::EffectSizes sizes = kernel::effect_sizes(declared, seen_of(problem, free.model));
  if (options.effects) {
    asked.effects = table_effects(sizes, problem.motion, problem.seen.parts, site);
    free = fit(problem, asked);
  }

  const std::string reversal = reversed_axis(free);
  kernel::Cleaned<Fit> cleaned{free, {}, {}, true};
  std::optional<Explained> explanation;
  if (options.effects) {
    explanation = explanation_of(free, sizes, options, reversal.empty());
    cleaned = {explanation->fit, explanation->dropped, explanation->worst, true};
  } else {
    if (options.terms.empty()) cleaned.fit = fit(problem, all_terms(free));
    if (reversal.empty()) cleaned = without_outliers(cleaned.fit, options.outlier_level);
  }
  const bool by_size = explanation && explanation->by_size;

  const Fit last = explanation || cleaned.fit.log_probability() <= std::log(unlikely) ? enlarged(cleaned.fit) : cleaned.fit;
  Calibration calibration = calibration_of(last);
  calibration.quality.chi2_per_dof = cleaned.fit.chi2 / std::max(1, calibration.quality.degrees_of_freedom);  // relative to the declarations
  if (options.terms.empty()) calibration.quality.term_tests = tests_of_terms(last, options.significance);
  Findings findings;
  for (const std::string& note : seen.notes) findings.add<Code::table_note>(note);
  for (const std::string& warning : seen.warnings) findings.add<Code::table_warning>(warning);
  if (!site.latitude) findings.add<Code::no_latitude>("was taken as unknown up to its size (15 deg/h), which the gyros' uncertainties contain");
  check_noise(findings, problem, calibration.model);
  if (!reversal.empty()) {
    findings.add<Code::reversed_axis>(reversal);
    findings.add<Code::wrong_sign_of_axis>();
  }
  kernel::add_dropped(findings, cleaned.dropped, problem.motion.parts());
  doubt_many_dropped(findings, cleaned.fit);
  if (options.terms.empty() && site.latitude) kernel::doubt_latitude(findings, calibration_of(free), *site.latitude, site.gravity());
  if (explanation) {
    add_effects(calibration, findings, last);
    kernel::doubt_improbable(findings, explanation->fit.options.effects.table, p_value(explanation->fit));
  }
  judge_residuals(findings, cleaned.fit, last, cleaned.worst, by_size);
  kernel::add_common_doubts(findings, calibration, site);
  kernel::conclude(calibration, findings);
  return calibration;
}

CalibrationResult calibrate(const CalibrationInput& input, const CalibrationOptions& options) {
  const Recording& recording = kernel::only_recording(input, "turntable");
  const Session& session = input.session;
  const TableObservations seen = observe(recording, session);
  CalibrationResult result{.calibration = calibrate(seen, turntable_of(session, recording.name), session.imu, session.site, options)};
  if (options.effects) expect_scales(result.calibration, recording);
  kernel::check_gyro_steps(result.calibration.quality.findings,
                           measure_mean_noise(recording, summarize_rests(recording, kernel::rests_of(input, recording).ranges)));
  kernel::judge(result.calibration.quality);
  return result;
}

}  // namespace imulab::turntable
