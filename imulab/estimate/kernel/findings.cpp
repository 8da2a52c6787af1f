#include "imulab/estimate/kernel/findings.hpp"

#include "imulab/core/decomposition.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/earth.hpp"
#include "imulab/units.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace imulab::kernel {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

UncertaintySource gravity_source(const Site& site) {
  const double relative = site.gravity_sigma() / site.gravity();
  return {"gravity", relative, fmt::format("g has u = {:.3g} ppm: this much is common to all three accelerometer scales", relative / unit::ppm)};
}

void check_declared_noise(Findings& findings, std::string_view triad, double ratio) {
  if (ratio > 1.5 || ratio < 1 / 1.5) findings.add<Code::noise_not_as_declared>(Subject{triad}, ratio);
}

void note_spread(Findings& findings, std::string_view what, double spread, std::string_view unit_name) {
  if (spread > 0) findings.add<Code::spread>(Subject{what}, spread, unit_name);
}

void warn_of_larger_terms(Findings& findings, std::vector<std::string> terms) {
  std::sort(terms.begin(), terms.end());
  terms.erase(std::unique(terms.begin(), terms.end()), terms.end());
  for (const std::string& term : terms) findings.add<Code::larger_term>(Subject{term});
}

void add_dropped(Findings& findings, const std::vector<std::string>& names, std::size_t all, std::string_view parts) {
  for (const std::string& name : names) findings.add<Code::dropped>(Subject{name});
  if (5 * names.size() > all) findings.add<Code::many_dropped>(names.size(), all, parts);
}

void check_gyro_steps(Findings& findings, const MeanNoise& noise) {
  for (Eigen::Index j = 0; j < 3; ++j)
    if (noise.rounding.gyro[j] > 0.025 * noise.step.gyro[j])  // if noise is below a third of the step, slopes within a step are wrong by a fifth
      return void(findings.add<Code::coarse_steps>());
}

double excess(double chi2, double degrees_of_freedom) {
  if (!(degrees_of_freedom >= 1) || chi_square_tail(chi2, degrees_of_freedom) > 1e-3) return 1;
  return std::max(1.0, std::sqrt(chi2 / degrees_of_freedom));
}

void add_scatter(Findings& findings, std::string_view what, double factor) {
  if (factor <= 1) return;
  findings.add<Code::scatter>(Subject{what}, factor).severity = factor > 1.5 ? Severity::doubt : Severity::warning;
}

void add_common_doubts(Findings& findings, const Calibration& calibration, const Site& site, double in_effects) {
  const Quality& quality = calibration.quality;
  if (!quality.converged) findings.add<Code::not_converged>();
  if (!quality.unobservable.empty())
    findings.add<Code::undetermined>(quality.unobservable.size() == 1 ? "a coefficient is"
                                                                      : fmt::format("{} coefficients are", quality.unobservable.size()));
  // With fewer than about six degrees of freedom, residuals and effects cannot contradict the model or the noise significantly.
  if (const double degrees = std::round(quality.degrees_of_freedom + in_effects); degrees < 6)
    findings.add<Code::few_degrees_of_freedom>(degrees, degrees == 1 ? "" : "s", degrees == 1 ? "s" : "");
  // Real hand-held sensors give 1 to 10; five times the noise implies another sensor, motion or place than declared.
  if (quality.chi2_per_dof > 25) findings.add<Code::large_residuals>(std::sqrt(quality.chi2_per_dof));
  for (const CoefficientIndex index : calibration.estimated) {
    const Coefficient& c = coefficient(index);
    if (!is_scale(c)) continue;
    const auto row = triad_model(calibration.model, c.triad).matrix.row(c.row);
    const double relative = *standard_uncertainty(calibration, index) / row.norm();
    if (relative > 0.01) findings.add<Code::uncertain_scale>(Subject{c.name}, 100 * relative);  // an uncalibrated unit has a few percent
  }
  if (!site.given_gravity) return;
  // Normal gravity is accurate to 0.005 m/s^2 at a known height, and up to 0.03 m/s^2 too large at unknown heights up to 10 km. On the Earth's
  // surface, g is between 9.76 and 9.84 m/s^2.
  const double expected = site.latitude ? normal_gravity(*site.latitude, site.height.value_or(0)) : 9.80;
  const double off = *site.given_gravity - expected;
  const double largest = !site.latitude ? 0.05 : site.height || off > 0 ? 0.005 : 0.03;
  if (std::abs(off) > std::max(largest, 3 * site.gravity_sigma()))
    findings.add<Code::wrong_gravity>(*site.given_gravity, site.latitude ? "the given latitude" : "the Earth's surface", expected);
}

namespace {

/// The part of the g-sensitivity that is equal on all axes, and the remainder.
struct EqualPart {
  double value, variance;
  double rest;   ///< RMS of an element of the remainder
  bool differs;  ///< the remainder is significant
};
std::optional<EqualPart> equal_g_sensitivity(const Calibration& c) {
  std::vector<Index> at;
  VectorXd value(9), alike = VectorXd::Zero(9);
  for (std::size_t i = 0; i < c.estimated.size(); ++i) {
    const Coefficient& row = coefficient(c.estimated[i]);
    if (row.term != Term::g_sensitivity) continue;
    const auto k = static_cast<Index>(at.size());
    value[k] = coefficient_value(c.model, c.estimated[i]);
    alike[k] = row.row == row.column ? 1 : 0;
    at.push_back(static_cast<Index>(i));
  }
  if (at.size() != 9) return {};
  const MatrixXd covariance = c.covariance(at, at);
  const VectorXd weight = solve_semidefinite(covariance, alike);
  const double variance = 1 / alike.dot(weight), common = variance * value.dot(weight);
  const VectorXd rest = value - common * alike;
  const bool differs = rest.norm() > 0.1 * std::abs(common) && chi_square_tail(squared_norm_in(covariance, rest), 8) < 1e-3;
  return EqualPart{common, variance, rest.norm() / std::sqrt(8), differs};
}

}  // namespace

bool is_of_session(Code code) {
  return code == Code::wrong_latitude || code == Code::not_earth_rate || code == Code::wrong_turn || code == Code::unexpected_site_effect;
}

void doubt_latitude(Findings& findings, const Calibration& calibration, double latitude, double gravity) {
  const auto equal = equal_g_sensitivity(calibration);
  if (!equal) return;
  if (equal->differs) {
    // The other sign of the latitude requires this equal part. It could be hidden in the IMU's own g-sensitivity if the remainder is as large.
    constexpr double few = 3;
    const double other = std::abs(2 * earth_rate * std::sin(latitude) / gravity);
    if (other > few * std::sqrt(equal->variance) && other < few * equal->rest)
      findings.add<Code::latitude_assumed>(latitude / unit::deg, other * unit::g / unit::deg_per_h);
    return;
  }
  const double sine = std::sin(latitude) - equal->value * gravity / earth_rate;
  if (equal->value * equal->value < 25 * equal->variance || std::abs(sine) > 1) return;
  const double instead = std::asin(sine);
  findings.add<Code::latitude_in_g_sensitivity>(
      instead / unit::deg, std::sqrt(equal->variance) * gravity / earth_rate / std::cos(instead) / unit::deg, latitude / unit::deg);
  findings.add<Code::wrong_latitude>();
}

void doubt_small_residuals(Quality& quality, const ImuDeclaration& imu) {
  const bool declared = imu.accel_noise_density || imu.gyro_noise_density || imu.accel_noise || imu.gyro_noise;
  if (declared && quality.chi2_per_dof < 0.3 && quality.degrees_of_freedom >= 6) quality.findings.add<Code::small_residuals>();
}

void judge(Quality& quality) {
  quality.verdict = quality.findings.doubtful() ? Verdict::doubtful : Verdict::good;
  if (quality.findings.has(Code::wrong_latitude)) quality.cause = "site.latitude";
}

void conclude(Calibration& calibration, const Findings& findings) {
  calibration.quality.findings.append(findings);
  judge(calibration.quality);
}

}  // namespace imulab::kernel
