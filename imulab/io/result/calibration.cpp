#include "imulab/io/result/calibration.hpp"

#include "imulab/core/units.hpp"
#include "imulab/estimate/method.hpp"
#include "imulab/model/coefficient.hpp"
#include "imulab/model/requirement.hpp"
#include "imulab/model/user_unit.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

namespace imulab {
namespace {

UserValue user_value(const Calibration& calibration, const Coefficient& c, double value, double sigma) {
  const bool accel = c.triad == Triad::accel;
  const TriadModel& triad = accel ? calibration.model.accel : calibration.model.gyro;
  const bool counts = triad.raw_unit == "count";
  const double scale = triad.matrix(c.row, c.row);
  switch (c.term) {
    case Term::offset: {
      if (counts) {
        const RawZero zero = raw_zero(calibration, c.triad);
        return {zero.value[c.row], zero.uncertainty[c.row], "count at zero"};
      }
      const double unit = accel ? unit::ug : unit::deg_per_h;
      return {value / unit, sigma / unit, accel ? "ug" : "deg/h"};
    }
    case Term::matrix:
      if (c.row != c.column) return {value / std::abs(scale) / unit::arcsec, sigma / std::abs(scale) / unit::arcsec, "arcsec"};
      if (counts) return {1 / scale, sigma / (scale * scale), accel ? "count/(m/s^2)" : "count/(rad/s)"};
      return {(scale - 1) / unit::ppm, sigma / unit::ppm, "ppm"};
    case Term::g_sensitivity:
      return {value / (unit::deg_per_h / unit::g), sigma / (unit::deg_per_h / unit::g), "deg/h/g"};
    case Term::lever_arm:
      return {1e3 * value, 1e3 * sigma, "mm"};
    default:
      break;
  }
  if (counts) return {value, sigma, ""};
  // Readings in SI: what a coefficient adds at one g, at one deg/s or in one kelvin.
  const std::string per = triad.temperature && triad.temperature->unit == "raw" ? "raw" : "K";
  const auto in = [&](double unit, const std::string& name) { return UserValue{value / unit, sigma / unit, name}; };
  if (c.term == Term::thermal)
    return in(accel ? unit::ug : unit::deg_per_h, fmt::format("{}/{}{}", accel ? "ug" : "deg/h", per, c.column == 2 ? "^2" : ""));
  const int order = c.term == Term::quadratic ? 2 : 3;
  return accel ? in(unit::ug / std::pow(unit::g, order), fmt::format("ug/g^{}", order))
               : in((order == 2 ? unit::ppm : 1e-9) / std::pow(unit::deg, order - 1), order == 2 ? "ppm/(deg/s)" : "ppb/(deg/s)^2");
}

std::string coefficient_row(const Calibration& calibration, CoefficientIndex index) {
  const Coefficient& c = coefficient(index);
  const double value = coefficient_value(calibration.model, index), sigma = *standard_uncertainty(calibration, index);
  const UserValue user = user_value(calibration, c, value, sigma);
  return fmt::format("  {:<24} {:>14.7g} {:>10.2g} {:>14.6g} {:>10.2g} {}\n", c.name, value, sigma, user.value, user.uncertainty, user.unit);
}

/// One row of Cheng's table 1, in user units.
std::string correction_row(const Calibration& calibration, const Calibration& coarse, CoefficientIndex index) {
  const Coefficient& c = coefficient(index);
  const double sigma = *standard_uncertainty(calibration, index);
  const UserValue before = user_value(coarse, c, coefficient_value(coarse.model, index), sigma);
  const UserValue after = user_value(calibration, c, coefficient_value(calibration.model, index), sigma);
  return fmt::format("  {:<24} {:>14.7g} {:>14.6g} {:>14.7g} {:>10.2g} {}\n", c.name, before.value, after.value - before.value, after.value,
                     after.uncertainty, after.unit);
}

std::string coefficient_rows(const Calibration& calibration, const SensorModel* coarse) {
  std::string text;
  if (coarse == nullptr) {
    text = fmt::format("  {:<24} {:>14} {:>10} {:>14} {:>10}\n", "coefficient", "value (SI)", "+/-", "in user units", "+/-");
    for (const CoefficientIndex index : calibration.estimated) text += coefficient_row(calibration, index);
    return text;
  }
  Calibration before = calibration;
  before.model = *coarse;
  text = fmt::format("  {:<24} {:>14} {:>14} {:>14} {:>10}\n", "coefficient", "coarse", "correction", "value", "+/-");
  for (const CoefficientIndex index : calibration.estimated) text += correction_row(calibration, before, index);
  return text;
}

std::string term_test_text(const TermTest& test) {
  if (test.degrees_of_freedom == 0) return fmt::format("  {}: the data say nothing of it; its prior counts in the uncertainties\n", test.term);
  std::string validation;
  if (test.cross_validation_with > 0)
    validation = fmt::format("; left-out points are missed by {:.3g} sigma with it, {:.3g} without", test.cross_validation_with,
                             test.cross_validation_without);
  return fmt::format("  {}: {} (chi2 {:.4g} with {} degrees of freedom, probability by chance {:.2g}{})\n", test.term,
                     test.kept ? "seen" : "not seen; its prior counts in the uncertainties", test.statistic, test.degrees_of_freedom, test.p_value,
                     validation);
}

/// The worst standard uncertainty of a group of coefficients, in user units; empty where none of them was estimated.
std::string worst_of(const Calibration& calibration, const char* selector) {
  double worst = -1;
  UserUnit unit{};
  for (const CoefficientIndex index : select_coefficients(selector)) {
    const double sigma = relative_uncertainty(calibration, index);
    if (!std::isfinite(sigma) || sigma <= worst) continue;
    worst = sigma;
    unit = user_unit(coefficient(index), sigma);
  }
  return worst < 0 ? "" : fmt::format("{:.2g} {}", worst / unit.size, unit.name);
}

/// What the calibration is good for, in a line a triad.
std::string reached_text(const Calibration& calibration) {
  std::string text;
  for (const auto& [name, triad] : {std::pair{"accelerometers", "accel"}, std::pair{"gyros", "gyro"}}) {
    std::string line;
    for (const auto& [what, term] : {std::pair{"scale", ".matrix.diagonal"}, {"misalignment", ".matrix.off_diagonal"}, {"offset", ".offset"}})
      if (const std::string worst = worst_of(calibration, (std::string(triad) + term).c_str()); !worst.empty())
        line += fmt::format("{}{} {}", line.empty() ? "" : ", ", what, worst);
    if (!line.empty()) text += fmt::format("  {} known to (worst axis, 1 sigma): {}\n", name, line);
  }
  return text;
}

std::string requirements_text(const Calibration& calibration) {
  std::string text;
  for (const RequirementResult& r : calibration.quality.requirements) {
    const CoefficientIndex index = coefficient_index(r.coefficient);
    const UserUnit unit = user_unit(coefficient(index), r.limit);
    const std::string reached = std::isfinite(r.reached) ? fmt::format("{:.3g} {}", r.reached / unit.size, unit.name) : "not determined";
    text += fmt::format("  {}: {} ({}: {})\n", r.text, r.met ? "reached" : "not reached", r.coefficient, reached);
  }
  return text;
}

}  // namespace

UserValue user_value(const Calibration& calibration, CoefficientIndex index) {
  return user_value(calibration, coefficient(index), coefficient_value(calibration.model, index), standard_uncertainty(calibration, index).value_or(NAN));
}

std::string curves_csv(const CalibrationResult& result) {
  std::string text = "t";
  for (const ConvergenceCurve& curve : result.curves) text += fmt::format(",{0},{0}.sigma", curve.name);
  text += "\n";
  for (std::size_t i = 0; i < result.curve_time.size(); ++i) {
    text += fmt::format("{:.3f}", result.curve_time[i]);
    for (const ConvergenceCurve& curve : result.curves) text += fmt::format(",{:.9g},{:.4g}", curve.residual[i], curve.sigma[i]);
    text += "\n";
  }
  return text;
}

std::string calibration_table(const Calibration& calibration, const SensorModel* coarse) {
  const Quality& quality = calibration.quality;
  std::string text =
      fmt::format("{}{}method {}, frame: {}\n\n", calibration.imu, calibration.imu.empty() ? "" : ", ", calibration.method, calibration.frame);
  text += coefficient_rows(calibration, coarse) + "\n";
  for (const std::string& note : quality.notes) text += fmt::format("  {}\n", note);
  for (const UncertaintySource& source : quality.sources) text += fmt::format("  {}\n", source.consequence);
  for (const TermTest& test : quality.term_tests) text += term_test_text(test);
  text += reached_text(calibration) + requirements_text(calibration);
  return text + fmt::format("  residuals: chi2 per degree of freedom {:.3g} against {} ({} degrees of freedom); condition {:.3g}\n\n{}\n",
                            quality.chi2_per_dof,
                            calibration.method == "turntable" || calibration.frame == "rig" ? "the noise and the declared rig errors"
                                                                                            : "the sample noise alone",
                            quality.degrees_of_freedom, quality.condition, verdict_text(quality));
}

}  // namespace imulab
