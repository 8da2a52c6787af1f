#include "imulab/estimate/turntable.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/core/units.hpp"
#include "imulab/earth/earth.hpp"
#include "imulab/estimate/common.hpp"
#include "imulab/estimate/turntable_fit.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace imulab {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// Table indices of the terms the method supplies.
std::vector<int> supplied_coefficients() {
  std::vector<int> indices;
  for (const char* selector : {"accel.offset", "accel.matrix", "gyro.offset", "gyro.matrix", "gyro.g_sensitivity"})
    for (const int index : select_coefficients(selector)) indices.push_back(index);
  return indices;
}

/// The forward model keeps a matrix whole or diagonal, and the other terms whole.
std::vector<int> chosen_coefficients(const std::vector<int>& wanted, const TableObservations& seen) {
  const std::vector<int> chosen = choose_terms(wanted, supplied_coefficients(), "turntable");
  const auto part = [&](const char* selector) {
    const std::vector<int> all = select_coefficients(selector);
    const auto found = std::count_if(all.begin(), all.end(), [&](int i) { return std::find(chosen.begin(), chosen.end(), i) != chosen.end(); });
    return std::pair{found, static_cast<std::ptrdiff_t>(all.size())};
  };
  for (const char* triad : {"accel", "gyro"}) {
    const auto [off, all_off] = part(fmt::format("{}.matrix.off_diagonal", triad).c_str());
    const auto [diagonal, all_diagonal] = part(fmt::format("{}.matrix.diagonal", triad).c_str());
    if ((diagonal != 0 && diagonal != all_diagonal) || (off != 0 && off != all_off) || (off > 0 && diagonal == 0))
      throw Error(fmt::format("--terms: of {0}.matrix the method turntable estimates all, or {0}.matrix.diagonal, or none", triad));
  }
  for (const char* term : {"accel.offset", "gyro.offset", "gyro.g_sensitivity"})
    if (const auto [found, all] = part(term); found != 0 && found != all)
      throw Error(fmt::format("--terms: the method turntable estimates all of {} or none", term));
  for (const auto& [triad, unit] : {std::pair{"accel", seen.accel_unit}, std::pair{"gyro", seen.gyro_unit}})
    if (unit == "count" &&
        (part(fmt::format("{}.offset", triad).c_str()).first == 0 || part(fmt::format("{}.matrix.diagonal", triad).c_str()).first == 0))
      throw Error(
          fmt::format("--terms: {0}.offset or {0}.matrix.diagonal is missing: readings in counts have no offset and scale to start from", triad));
  return chosen;
}

std::vector<int> without_g_sensitivity(std::vector<int> terms) {
  std::erase_if(terms, [](int index) { return coefficient_table()[static_cast<std::size_t>(index)].term == Term::g_sensitivity; });
  return terms;
}

/// A declared unit mistaken for another: the scale then is that of the other unit. Uncalibrated scales are within 20 %.
void check_units(const TableObservations& seen, const SensorModel& model) {
  const double accel = std::cbrt(std::abs(model.accel.matrix.determinant())), gyro = std::cbrt(std::abs(model.gyro.matrix.determinant()));
  const auto near = [](double value, double expected) { return std::abs(value / expected - 1) < 0.2; };
  const auto mistaken = [](const char* triad, double scale, const char* looks) {
    return Error(fmt::format(
        "{0}: the table's motion is {1:.3g} times what the readings say with the declared unit: they look like {2}; declare unit = \"{2}\"", triad,
        scale, looks));
  };
  if (seen.accel_unit != "count" && near(accel, unit::g)) throw mistaken("accel", accel, "g");
  if (seen.accel_unit != "count" && near(accel, 1 / unit::g)) throw mistaken("accel", accel, "m/s^2");
  if (seen.gyro_unit != "count" && near(gyro, unit::deg)) throw mistaken("gyro", gyro, "deg/s");
  if (seen.gyro_unit != "count" && near(gyro, 1 / unit::deg)) throw mistaken("gyro", gyro, "rad/s");
  if (seen.gyro_unit != "count" && near(gyro, 1 / unit::deg_per_h)) throw mistaken("gyro", gyro, "rad/s");
}

/// A scale that no sensor read in SI has: another unit, increments declared as rates or rates as increments.
void doubt_scales(const TableObservations& seen, const SensorModel& model, Quality& quality, std::vector<std::string>& doubts) {
  const auto check = [&](const char* triad, const std::string& unit, const Matrix3d& matrix) {
    const double scale = std::cbrt(std::abs(matrix.determinant()));
    if (unit == "count" || std::abs(scale - 1) < 0.2) return;
    quality.warnings.push_back(
        fmt::format("{}: the table's motion is {:.4g} times what the readings say with the declared unit: is unit or output right?", triad, scale));
    doubts.push_back(fmt::format("the {}'s scale is far from its declared unit's", triad));
  };
  check("accel", seen.accel_unit, model.accel.matrix);
  check("gyro", seen.gyro_unit, model.gyro.matrix);
}

/// Up is along the force in every position, so an error of the vertical Earth rate looks exactly like the same g-sensitivity of all axes.
void doubt_latitude(const SensorModel& model, const Site& site, Quality& quality, std::vector<std::string>& doubts) {
  const double common = model.g_sensitivity.trace() / 3;
  if (!site.latitude || common == 0 || (model.g_sensitivity - common * Matrix3d::Identity()).norm() > 0.1 * std::abs(common)) return;
  const double up = earth_rate * std::sin(*site.latitude) + common * site.gravity();  // the Earth rate that would need no g-sensitivity
  quality.warnings.push_back(fmt::format(
      "the g-sensitivity is the same on all axes, as an error of the latitude is: Earth's vertical rate would be {:.4g} instead of {:.4g} deg/h{}",
      up / unit::deg_per_h, earth_rate * std::sin(*site.latitude) / unit::deg_per_h,
      std::abs(up) < earth_rate ? fmt::format(", that of latitude {:.3g} deg", std::asin(up / earth_rate) / unit::deg) : ""));
  doubts.push_back("the latitude seems to be wrong");
}

TermTest test_g_sensitivity(const TurntableFit& fit, double significance) {
  const auto uncertainty = fit.estimator.uncertainty(fit.model);
  std::vector<Index> at;
  for (std::size_t i = 0; i < uncertainty.determined.size(); ++i)
    if (coefficient_table()[static_cast<std::size_t>(uncertainty.determined[i])].term == Term::g_sensitivity) at.push_back(static_cast<Index>(i));
  TermTest test{"gyro.g_sensitivity", 0, static_cast<int>(at.size()), 1, false};
  if (at.empty()) return test;
  VectorXd value(static_cast<Index>(at.size()));
  for (std::size_t i = 0; i < at.size(); ++i)
    value[static_cast<Index>(i)] = coefficient_value(fit.model, uncertainty.determined[static_cast<std::size_t>(at[i])]);
  test.statistic = value.dot(Eigen::MatrixXd(uncertainty.covariance(at, at)).ldlt().solve(value));
  test.p_value = chi_square_tail(test.statistic, test.degrees_of_freedom);
  test.kept = test.p_value <= significance;
  return test;
}

void compare_noise(const TableObservations& seen, const SensorModel& model, const ImuDeclaration& imu, Quality& quality) {
  const auto compare = [&](const char* what, const std::optional<double>& declared, const Vector3d& measured, const Matrix3d& matrix) {
    if (!declared || !(measured.norm() > 0)) return;
    const double ratio = measured.norm() / std::sqrt(raw_density(*declared, matrix).trace());
    if (ratio > 1.5 || ratio < 1 / 1.5)
      quality.warnings.push_back(
          fmt::format("the {}' noise at rest is {:.2g} times the declared density; the declared one sets the weights", what, ratio));
  };
  compare("accelerometers", imu.accel_noise_density, seen.accel_density, model.accel.matrix);
  compare("gyros", imu.gyro_noise_density, seen.gyro_density, model.gyro.matrix);
}

/// Residuals against the declared noise and table.
void judge_residuals(const TurntableFit& fit, const std::string& worst, Quality& quality, std::vector<std::string>& doubts) {
  quality.degrees_of_freedom = fit.estimator.degrees_of_freedom();
  quality.condition = fit.estimator.condition();
  quality.chi2_per_dof = fit.chi2 / std::max(1, quality.degrees_of_freedom);
  if (quality.degrees_of_freedom < 1) return;
  if (fit.log_probability() < std::log(by_chance)) {
    quality.warnings.push_back(
        fmt::format("the residuals are {:.3g} times what the noise and the declared table errors explain: the uncertainties are too small{}",
                    std::sqrt(quality.chi2_per_dof), worst.empty() ? "" : "; most of all " + worst));
    doubts.push_back("the residuals exceed the declared noise and table errors");
  } else if (chi_square_tail(fit.chi2, quality.degrees_of_freedom) > 1 - by_chance) {
    quality.warnings.push_back(
        fmt::format("the residuals are only {:.3g} times what the noise and the declared table errors explain: the table is better than declared, or the samples' noise is not white (quantisation averages out faster; declare the densities)",
                    std::sqrt(quality.chi2_per_dof)));
  }
}

}  // namespace

Calibration calibrate_turntable(const TableObservations& seen, const RigDeclaration& rig, const ImuDeclaration& imu, const Site& site,
                                const TurntableOptions& options) {
  if (!seen.noise_measured && !(imu.accel_noise_density && imu.gyro_noise_density))
    throw Unsupported("the holds are too short to measure the noise from: [imu] accel_noise_density and gyro_noise_density were expected");
  const TableMotion motion(seen, rig, site);
  const TurntableProblem problem{seen, motion, imu, seen.values()};
  TurntableSettings settings;
  settings.terms = options.terms.empty() ? supplied_coefficients() : chosen_coefficients(options.terms, seen);
  settings.bias_while_turning = options.bias_while_turning;
  TurntableFit fit = fit_turntable(problem, settings);
  check_units(seen, fit.model);

  const std::string reversal = reversed_axis(problem, fit, rig, site, settings);
  CleanedFit cleaned = reversal.empty() ? drop_outliers(problem, fit, settings, options.outlier_level) : CleanedFit{fit, {}, {}};
  Calibration calibration;
  Quality& quality = calibration.quality;
  if (options.terms.empty()) {
    quality.term_tests.push_back(test_g_sensitivity(cleaned.fit, options.significance));
    if (!quality.term_tests.back().kept) {
      settings.terms = without_g_sensitivity(settings.terms);
      cleaned.fit = fit_turntable(problem, settings);
    }
  }

  const auto uncertainty = cleaned.fit.estimator.uncertainty(cleaned.fit.model);
  if (uncertainty.determined.empty())
    throw Unsupported("the steps determine no coefficient: holds with each axis up and down, and turns about each axis, are needed");
  calibration.imu = imu.name;
  calibration.method = "turntable";
  calibration.frame = "rig";
  calibration.model = cleaned.fit.model;
  calibration.model.accel.raw_unit = seen.accel_unit;
  calibration.model.gyro.raw_unit = seen.gyro_unit;
  calibration.estimated = uncertainty.determined;
  const auto second = cleaned.fit.estimator.second_order(calibration.model, calibration.estimated);
  for (std::size_t i = 0; i < calibration.estimated.size(); ++i) {
    const int index = calibration.estimated[i];
    set_coefficient(calibration.model, index, coefficient_value(calibration.model, index) - second.bias[static_cast<Index>(i)]);
  }
  calibration.covariance = uncertainty.covariance + second.covariance;
  for (const int index : uncertainty.undetermined) quality.unobservable.emplace_back(coefficient_table()[static_cast<std::size_t>(index)].name);
  quality.notes = seen.notes;
  quality.warnings = seen.warnings;
  const double relative = site.gravity_sigma() / site.gravity();
  quality.sources.push_back(
      {"gravity", relative, fmt::format("g is known to {:.3g} ppm: this much is common to all three accelerometer scales", 1e6 * relative)});
  if (!site.latitude)
    quality.notes.push_back("no latitude: Earth's rate was taken as unknown up to its size (15 deg/h) and is counted in the gyros' uncertainties");
  compare_noise(seen, calibration.model, imu, quality);
  std::vector<std::string> doubts;
  if (!reversal.empty()) {
    quality.warnings.push_back(reversal);
    doubts.push_back("the sign of an axis seems to be wrong");
  }
  for (const std::string& name : cleaned.dropped) quality.warnings.push_back("dropped as an outlier: " + name);
  doubt_scales(seen, calibration.model, quality, doubts);
  doubt_latitude(calibration.model, site, quality, doubts);
  judge_residuals(cleaned.fit, cleaned.worst, quality, doubts);
  for (const std::string& doubt : common_doubts(calibration, site, cleaned.dropped.size(), seen.holds.size() + seen.turns.size()))
    doubts.push_back(doubt);
  conclude(calibration, doubts);
  return calibration;
}

Calibration calibrate_turntable(const Recording& recording, const Session& session, const TurntableOptions& options) {
  return calibrate_turntable(observe(recording, session), turntable_of(session, recording.name), session.imu, session.site, options);
}

}  // namespace imulab
