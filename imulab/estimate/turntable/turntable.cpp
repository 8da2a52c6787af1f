#include "imulab/estimate/turntable/turntable.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/core/units.hpp"
#include "imulab/earth/earth.hpp"
#include "imulab/estimate/kernel/findings.hpp"
#include "imulab/estimate/kernel/input.hpp"
#include "imulab/estimate/kernel/terms.hpp"
#include "imulab/estimate/turntable/fit.hpp"

#include <Eigen/LU>
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

namespace imulab::turntable {

using Eigen::Index;
using Eigen::VectorXd;
using kernel::Findings;

namespace {

/// The forward model keeps a matrix whole or diagonal, and the other terms whole.
std::vector<CoefficientIndex> chosen_coefficients(const std::vector<CoefficientIndex>& wanted, const TableObservations& seen) {
  const std::vector<CoefficientIndex> chosen = kernel::chosen_coefficients(
      wanted, select_each({"accel.offset", "accel.matrix", "gyro.offset", "gyro.matrix", "gyro.g_sensitivity"}), "turntable");
  enum class Share { none, some, all };
  const auto share = [&](const std::string& selector) {
    const std::vector<CoefficientIndex> whole = select_coefficients(selector);
    const auto n = std::count_if(whole.begin(), whole.end(), [&](CoefficientIndex index) { return contains(chosen, index); });
    return n == std::ssize(whole) ? Share::all : n > 0 ? Share::some : Share::none;
  };
  for (const auto& [triad, unit] : {std::pair{std::string("accel"), seen.accel_unit}, {std::string("gyro"), seen.gyro_unit}}) {
    const Share diagonal = share(triad + ".matrix.diagonal"), others = share(triad + ".matrix.off_diagonal");
    if (diagonal == Share::some || others == Share::some || (others == Share::all && diagonal == Share::none))
      throw TermsError(fmt::format("{0}.matrix in parts: the method turntable estimates all of it, or {0}.matrix.diagonal, or none", triad));
    if (unit == "count" && (share(triad + ".offset") == Share::none || diagonal == Share::none))
      throw TermsError(fmt::format("without {0}.offset or {0}.matrix.diagonal: readings in counts have no offset and scale to start from", triad));
  }
  for (const char* term : {"accel.offset", "gyro.offset", "gyro.g_sensitivity"})
    if (share(term) == Share::some) throw TermsError(fmt::format("{} in parts: the method turntable estimates all of it or none", term));
  return chosen;
}

/// What is declared and observed of a triad, and what was found.
struct TriadView {
  Triad triad;
  std::string_view sensors;
  const std::string& unit;
  const std::optional<double>& declared_density;
  const Vector3d& density;
  const Matrix3d& matrix;

  /// Mean scale of readings in SI; none of counts.
  std::optional<double> scale() const { return unit == "count" ? std::nullopt : std::optional(std::cbrt(std::abs(matrix.determinant()))); }
};

std::array<TriadView, 2> triads(const Problem& problem, const SensorModel& model) {
  const auto& [seen, imu] = std::tie(problem.seen, problem.imu);
  return {{{Triad::accel, "accelerometers", seen.accel_unit, imu.accel_noise_density, seen.accel_density, model.accel.matrix},
           {Triad::gyro, "gyros", seen.gyro_unit, imu.gyro_noise_density, seen.gyro_density, model.gyro.matrix}}};
}

/// Throws Error where a declared unit was mistaken for another.
void expect_units(const Problem& problem, const SensorModel& model) {
  for (const TriadView& view : triads(problem, model))
    if (const std::string_view looks = view.scale() ? kernel::mistaken_unit(view.triad, *view.scale()) : ""; !looks.empty())
      throw Error(fmt::format("{}: the table's motion is {:.3g} times what the readings say; they look like {}; correct their unit",
                              to_string(view.triad), *view.scale(), looks));
}

/// A scale that no sensor read in SI has: another unit, increments declared as rates or rates as increments.
void doubt_scales(Findings& findings, const Problem& problem, const SensorModel& model) {
  for (const TriadView& view : triads(problem, model)) {
    if (std::abs(view.scale().value_or(1) - 1) < 0.2) continue;
    findings.warn(
        fmt::format("{}: the table's motion is {:.4g} times what the readings say; the scale is implausible for an IMU; check the declared "
                    "unit and whether the readings are rates or increments",
                    to_string(view.triad), *view.scale()));
    findings.doubt(fmt::format("the {}'s scale is far from its declared unit's", to_string(view.triad)));
  }
}

void check_noise(Findings& findings, const Problem& problem, const SensorModel& model) {
  for (const TriadView& view : triads(problem, model))
    if (view.declared_density && view.density.norm() > 0)
      kernel::check_declared_noise(findings, view.sensors, view.density.norm() / std::sqrt(raw_density(*view.declared_density, view.matrix).trace()));
}

/// Up is along the force in every position, so an error of the vertical Earth rate looks exactly like the same g-sensitivity of all axes.
void doubt_latitude(Findings& findings, const SensorModel& model, const Site& site) {
  const double common = model.g_sensitivity.trace() / 3;
  if (!site.latitude || common == 0 || (model.g_sensitivity - common * Matrix3d::Identity()).norm() > 0.1 * std::abs(common)) return;
  const double up = earth_rate * std::sin(*site.latitude) + common * site.gravity();  // the Earth rate that would need no g-sensitivity
  findings.warn(fmt::format(
      "the g-sensitivity is the same on all axes, as an error of the latitude is; Earth's vertical rate would be {:.4g} instead of {:.4g} deg/h{}; "
      "check the latitude",
      up / unit::deg_per_h, earth_rate * std::sin(*site.latitude) / unit::deg_per_h,
      std::abs(up) < earth_rate ? fmt::format(", that of latitude {:.3g} deg", std::asin(up / earth_rate) / unit::deg) : ""));
  findings.doubt("the latitude seems to be wrong");
}

TermTest test_g_sensitivity(const Fit& fit, double significance) {
  const Estimator::Uncertainty uncertainty = fit.estimator.uncertainty(fit.model);
  kernel::TermGroup group{"gyro.g_sensitivity", {}};
  VectorXd values(uncertainty.covariance.rows());
  for (Index i = 0; i < values.size(); ++i) {
    const CoefficientIndex index = uncertainty.determined[static_cast<std::size_t>(i)];
    values[i] = coefficient_value(fit.model, index);
    if (coefficient(index).term == Term::g_sensitivity) group.members.push_back(i);
  }
  return kernel::wald(group, values, uncertainty.covariance, significance);
}

/// Residuals against the declared noise and table.
void judge_residuals(Findings& findings, const Fit& fit, const std::string& worst, const Quality& quality) {
  if (quality.degrees_of_freedom < 1) return;
  const double ratio = std::sqrt(quality.chi2_per_dof);
  if (fit.log_probability() < std::log(unlikely)) {
    findings.warn(
        fmt::format("the residuals are {:.3g} times what the noise and the declared table errors explain; the uncertainties are too small{}", ratio,
                    worst.empty() ? "" : "; most of all " + worst));
    findings.doubt("the residuals exceed the declared noise and table errors");
  } else if (chi_square_tail(fit.chi2, quality.degrees_of_freedom) > 1 - unlikely) {
    findings.warn(
        fmt::format("the residuals are only {:.3g} times what the noise and the declared table errors explain; the table is better than "
                    "declared, or the samples' noise is not white (quantization averages out faster); declare the noise densities",
                    ratio));
  }
}

/// Model, covariance and residuals of a fit, with the bias of the second order taken out.
Calibration calibration_of(const Fit& fit) {
  const Problem& problem = *fit.problem;
  Calibration calibration;
  calibration.imu = problem.imu.name;
  calibration.method = "turntable";
  calibration.frame = "rig";
  calibration.model = fit.model;
  calibration.model.accel.raw_unit = problem.seen.accel_unit;
  calibration.model.gyro.raw_unit = problem.seen.gyro_unit;
  const Estimator::Uncertainty uncertainty = fit.estimator.uncertainty(fit.model);
  if (uncertainty.determined.empty())
    throw Unsupported("the steps determine no coefficient; holds with each axis up and down, and turns about each axis, are needed");
  calibration.estimated = uncertainty.determined;
  const Estimator::SecondOrder second = fit.estimator.second_order(calibration.model, calibration.estimated);
  for (Index i = 0; i < second.bias.size(); ++i) {
    const CoefficientIndex index = calibration.estimated[static_cast<std::size_t>(i)];
    set_coefficient(calibration.model, index, coefficient_value(calibration.model, index) - second.bias[i]);
  }
  calibration.covariance = uncertainty.covariance + second.covariance;
  Quality& quality = calibration.quality;
  for (const CoefficientIndex index : uncertainty.undetermined) quality.unobservable.emplace_back(coefficient(index).name);
  quality.degrees_of_freedom = fit.estimator.degrees_of_freedom();
  quality.condition = fit.estimator.condition();
  quality.chi2_per_dof = fit.chi2 / std::max(1, quality.degrees_of_freedom);
  quality.sources.push_back(kernel::gravity_source(problem.site));
  return calibration;
}

}  // namespace

Calibration calibrate(const TableObservations& seen, const RigDeclaration& rig, const ImuDeclaration& imu, const Site& site,
                      const CalibrationOptions& options) {
  if (!seen.noise_measured && !(imu.accel_noise_density && imu.gyro_noise_density))
    throw Unsupported("the holds are too short to measure the sensors' noise; declare the noise densities of accelerometers and gyros");
  const Problem problem(seen, rig, imu, site);
  EstimatorOptions asked;
  asked.terms = chosen_coefficients(options.terms, seen);
  asked.bias_while_turning = options.turntable.bias_while_turning;
  const Fit whole = fit(problem, asked);
  expect_units(problem, whole.model);

  const std::string reversal = reversed_axis(whole);
  kernel::Cleaned<Fit> cleaned{whole, {}, {}, true};
  if (reversal.empty()) cleaned = without_outliers(whole, options.outlier_level);
  std::vector<TermTest> tests;
  if (options.terms.empty()) {
    tests.push_back(test_g_sensitivity(cleaned.fit, options.significance));
    EstimatorOptions fewer = cleaned.fit.options;
    std::erase_if(fewer.terms, [](CoefficientIndex index) { return coefficient(index).term == Term::g_sensitivity; });
    if (!tests.back().kept) cleaned.fit = fit(problem, fewer);
  }

  Calibration calibration = calibration_of(cleaned.fit);
  calibration.quality.term_tests = tests;
  Findings findings{seen.notes, seen.warnings, {}};
  if (!site.latitude)
    findings.note("no latitude: Earth's rate was taken as unknown up to its size (15 deg/h), which the gyros' uncertainties contain");
  check_noise(findings, problem, calibration.model);
  if (!reversal.empty()) {
    findings.warn(reversal);
    findings.doubt("the sign of an axis seems to be wrong");
  }
  kernel::add_dropped(findings, cleaned.dropped, problem.motion.parts());
  doubt_scales(findings, problem, calibration.model);
  doubt_latitude(findings, calibration.model, site);
  judge_residuals(findings, cleaned.fit, cleaned.worst, calibration.quality);
  kernel::add_common_doubts(findings, calibration, site);
  kernel::conclude(calibration, findings);
  return calibration;
}

CalibrationResult calibrate(const CalibrationInput& input, const CalibrationOptions& options) {
  const Recording& recording = kernel::only_recording(input, "turntable");
  const Session& session = input.session;
  const TableObservations seen = observe(recording, session);
  return {.calibration = calibrate(seen, turntable_of(session, recording.name), session.imu, session.site, options)};
}

}  // namespace imulab::turntable
