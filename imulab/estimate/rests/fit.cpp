#include "imulab/estimate/rests/fit.hpp"

#include "imulab/core/units.hpp"
#include "imulab/model/gauge.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace imulab::rests {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// A triad's scale farther from its prior than an IMU can be: the rests are too similar, and the fit has moved along what they do not determine.
const Coefficient* implausible_scale(const RestProblem& problem, const Fit& fit, Triad triad) {
  for (const Index i : fit.parameters.with(kernel::Role::estimated)) {
    if (i >= static_cast<Index>(problem.indices().size())) continue;
    const CoefficientIndex index = problem.indices()[static_cast<std::size_t>(i)];
    const Coefficient& c = coefficient(index);
    if (c.triad != triad || c.term != Term::matrix || c.row != c.column) continue;
    const double moved = coefficient_value(problem.model(), index) - coefficient_value(problem.prior(), index);
    if (!(std::abs(moved) <= prior_sigma(problem.prior(), c, 1.0))) return &c;
  }
  return nullptr;
}

/// Which of the problem's coefficients the fit determines. An implausible triad is not determined; without the accelerometers nothing is.
std::vector<char> determined(const RestProblem& problem, const Fit& fit, std::vector<std::string>& warnings) {
  std::vector<char> out;
  for (std::size_t i = 0; i < problem.indices().size(); ++i) out.push_back(fit.parameters.role[i] == kernel::Role::estimated);
  for (const Triad triad : {Triad::accel, Triad::gyro}) {
    const Coefficient* c = implausible_scale(problem, fit, triad);
    if (!c) continue;
    warnings.push_back(fmt::format("{} is implausible for an IMU: the rests are too similar; {}", c->name,
                                   triad == Triad::accel ? "nothing of the fit is used" : "nothing of the gyros' fit is used"));
    for (std::size_t i = 0; i < out.size(); ++i)
      if (triad == Triad::accel || coefficient(problem.indices()[i]).triad == triad) out[i] = 0;
    if (triad == Triad::accel) break;
  }
  return out;
}

}  // namespace

Calibration calibration_of(std::string_view method, const kernel::RestStart& start, const RestProblem& problem, const Fit& fit,
                           const Session& session) {
  Calibration out;
  out.imu = session.imu.name;
  out.method = method;
  const std::vector<CoefficientIndex>& indices = problem.indices();
  const std::vector<char> kept = determined(problem, fit, out.quality.warnings);
  SensorModel scaled = problem.model();
  for (std::size_t i = 0; i < indices.size(); ++i)
    if (!kept[i]) set_coefficient(scaled, indices[i], coefficient_value(problem.prior(), indices[i]));
  out.model = to_raw(scaled, start.scaling);
  const auto n = static_cast<Index>(indices.size());
  Eigen::MatrixXd covariance =
      covariance_after([&](const SensorModel& m) { return to_raw(m, start.scaling); }, indices, fit.covariance().topLeftCorner(n, n));

  // g is the scale: accelerations are proportional to it, g-sensitivity inversely.
  const UncertaintySource gravity = kernel::gravity_source(session.site);
  VectorXd by_gravity = VectorXd::Zero(n);
  std::vector<Index> at;
  for (std::size_t i = 0; i < indices.size(); ++i) {
    const Coefficient& c = coefficient(indices[i]);
    const double value = coefficient_value(out.model, indices[i]);
    by_gravity[static_cast<Index>(i)] = c.triad == Triad::accel ? value : c.term == Term::g_sensitivity ? -value : 0;
    if (kept[i]) {
      at.push_back(static_cast<Index>(i));
      out.estimated.push_back(indices[i]);
    } else {
      out.quality.unobservable.emplace_back(c.name);
    }
  }
  covariance += gravity.relative * gravity.relative * by_gravity * by_gravity.transpose();
  out.covariance = covariance(at, at);
  const kernel::Solution& under_noise = fit.under_noise.solution;
  out.quality.degrees_of_freedom = static_cast<int>(std::lround(under_noise.degrees_of_freedom));
  out.quality.chi2_per_dof = under_noise.chi2 / std::max(1.0, under_noise.degrees_of_freedom);
  out.quality.condition = kernel::condition_number(fit.conditions.information(), fit.parameters);
  out.quality.sources.push_back(gravity);
  out.quality.converged = fit.converged;
  return out;
}

void add_findings(kernel::Findings& findings, const Calibration& calibration, const Fit& fit, const Site& site,
                  const std::vector<std::string>& dropped, std::size_t all) {
  kernel::note_spread(findings, "the rests' accelerometer means", fit.spreads[0] / unit::ug, "ug");
  kernel::note_spread(findings, "the rests' gyro means", fit.spreads[1] / unit::deg_per_h, "deg/h");
  kernel::note_spread(findings, "the rotations", fit.spreads[2] / unit::deg, "deg");
  kernel::add_common_doubts(findings, calibration, site);
  kernel::add_dropped(findings, dropped, all);
  // A spread from ten residuals is good to a quarter; from fewer the uncertainties may be far too small.
  if (const double degrees = fit.spread_degrees(); degrees < 10)
    findings.doubt(fmt::format("the spread beyond the sample noise rests on {:.0f} degrees of freedom", degrees));
}

}  // namespace imulab::rests
