#include "imulab/estimate/rests/fit.hpp"

#include "imulab/core/decomposition.hpp"
#include "imulab/estimate/kernel/effect_findings.hpp"
#include "imulab/estimate/kernel/terms.hpp"
#include "imulab/model/gauge.hpp"
#include "imulab/units.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace imulab::rests {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// Returns a `determined` scale of the triad that is implausibly far from its prior. The data are then too poor, and the fit has moved along
/// directions that they do not determine.
const Coefficient* implausible_scale(const RestProblem& problem, const std::vector<char>& determined, Triad triad) {
  for (std::size_t i = 0; i < determined.size(); ++i) {
    const CoefficientIndex index = problem.indices()[i];
    const Coefficient& c = coefficient(index);
    if (!determined[i] || c.triad != triad || !is_scale(c)) continue;
    const double moved = coefficient_value(problem.model(), index) - coefficient_value(problem.prior(), index);
    if (!(std::abs(moved) <= problem.prior_sigma(c))) return &c;
  }
  return nullptr;
}

/// The coefficients that the result states: determined ones, and optional ones at least with their prior. An implausible triad is not stated; if it
/// is the accelerometers, no coefficient is.
struct Stated {
  std::vector<char> kept;
  bool implausible = false;
};
Stated stated(const RestProblem& problem, const Eigen::MatrixXd& covariance, Findings& findings) {
  Stated result;
  std::vector<char>& out = result.kept;
  for (std::size_t i = 0; i < problem.indices().size(); ++i) {
    const Coefficient& c = coefficient(problem.indices()[i]);
    const auto at = static_cast<Index>(i);
    const bool determined = std::sqrt(covariance(at, at)) < kernel::needed_sigma(c, problem.prior_sigma(c));
    out.push_back(is_optional(c.term) ? !problem.unstated(i) : determined);
  }
  for (const Triad triad : {Triad::accel, Triad::gyro}) {
    const Coefficient* c = implausible_scale(problem, out, triad);
    if (!c) continue;
    result.implausible = true;
    const TriadModel& prior = triad_model(problem.prior(), triad);
    const double scale = triad_model(problem.model(), triad).matrix(c->row, c->row) / prior.matrix(c->row, c->row);
    findings.add<Code::implausible_scale>(
        Subject{c->name}, scale,
        prior.raw_unit == "count" ? "the coarse solution is" : "the declared unit gives; check the unit and this axis's column, and the stamps, or",
        triad == Triad::accel ? "the rests are too similar; nothing of the fit is used"
                              : "the rotations are too few or do not fit; nothing of the gyros' fit is used");
    for (std::size_t i = 0; i < out.size(); ++i)
      if (triad == Triad::accel || coefficient(problem.indices()[i]).triad == triad) out[i] = 0;
    if (triad == Triad::accel) break;
  }
  return result;
}

/// Corrects the other coefficients for unstated ones, which return to their prior. For example, an offset was estimated together with the scale of
/// the readings at rest, and inherits the prior uncertainty of that scale.
VectorXd with_unstated_at_prior(const RestProblem& problem, const std::vector<char>& kept, Eigen::MatrixXd& covariance) {
  kernel::Parameters parameters(covariance.rows());
  for (std::size_t i = 0; i < kept.size(); ++i) {
    const CoefficientIndex index = problem.indices()[i];
    const Coefficient& c = coefficient(index);
    if (kept[i] || is_optional(c.term)) continue;
    parameters.role[i] = kernel::Role::considered;
    parameters.offset[static_cast<Index>(i)] = coefficient_value(problem.prior(), index) - coefficient_value(problem.model(), index);
    parameters.sigma[static_cast<Index>(i)] = problem.prior_sigma(c);
  }
  VectorXd correction = VectorXd::Zero(covariance.rows());
  kernel::consider(correction, covariance, parameters);
  return correction;
}

/// Returns the residual of a part that the fit used.
PartResidual part_residual(const SuspectRows& part, const Fit& fit) {
  PartResidual out{part.begin_s, part.end_s, 0, true};
  int rows = 0;
  for (const Index i : part.rows) {  // the rows of a rest include the rotation before it, which is a part of its own
    if ((fit.conditions.kind[static_cast<std::size_t>(i)] >= Kind::rotation) != part.rotation) continue;
    out.residual += fit.adjustment.residual[i] * fit.adjustment.residual[i] / fit.adjustment.variance[i];
    ++rows;
  }
  out.residual = std::sqrt(out.residual / std::max(rows, 1));
  return out;
}

/// Returns the raw covariance of these coefficients, the problem's first, for an exact g.
Eigen::MatrixXd raw_covariance_at_g(const RestProblem& problem, const std::vector<CoefficientIndex>& indices, Eigen::MatrixXd covariance) {
  for (std::size_t i = 0; i < problem.indices().size(); ++i)  // the term is defined about the center of the readings, not about their zero
    if (problem.unstated(i)) covariance.row(static_cast<Index>(i)).setZero(), covariance.col(static_cast<Index>(i)).setZero();
  return covariance_after([&](const SensorModel& m) { return to_raw(m, problem.scaling()); }, indices, covariance);
}

Eigen::MatrixXd raw_covariance_of(const RestProblem& problem, const std::vector<CoefficientIndex>& indices, Eigen::MatrixXd covariance) {
  covariance = raw_covariance_at_g(problem, indices, std::move(covariance));
  // g defines the scale: accelerations are proportional to it, g-sensitivity is inversely proportional.
  const SensorModel raw = to_raw(problem.model(), problem.scaling());
  VectorXd by_gravity = VectorXd::Zero(covariance.rows());
  for (std::size_t i = 0; i < indices.size(); ++i) {
    const Coefficient& c = coefficient(indices[i]);
    const double value = coefficient_value(raw, indices[i]);
    if (!is_thermal(c.term)) by_gravity[static_cast<Index>(i)] = c.triad == Triad::accel ? value : c.term == Term::g_sensitivity ? -value : 0;
  }
  const double relative = problem.relative_gravity_sigma();
  return covariance + relative * relative * by_gravity * by_gravity.transpose();
}

/// The thermal terms of scaled readings, from the effects of the outputs: A1 (c1 tau + c2 tau^2 + c3 tau^3) = b1 warming + b2 warming^2 / 50 K +
/// b3 warming^3 / (50 K)^2, -(M1 tau + M2 tau^2) = B1 warming + B2 warming^2 / 50 K.
struct ThermalTerms {
  std::vector<CoefficientIndex> indices;
  Eigen::MatrixXd by_parameter;  ///< a row per coefficient
  VectorXd value, prior;         ///< prior: one sigma
};

ThermalTerms thermal_terms(const RestProblem& problem, Index parameters) {
  ThermalTerms out;
  const kernel::Effects& effects = problem.effects();
  std::vector<VectorXd> rows;
  const auto add = [&](CoefficientIndex index, Index first, const VectorXd& by_effect) {
    VectorXd row = VectorXd::Zero(parameters);
    row.segment(parameters - effects.size() + first, by_effect.size()) = by_effect;
    out.indices.push_back(index);
    rows.push_back(std::move(row));
  };
  for (const kernel::EffectGroup& g : effects.groups()) {
    if ((g.effect->needs & Effect::by_sweep) == 0 || !problem.sweep()) continue;
    const Triad triad = g.effect->changes(Triad::accel) ? Triad::accel : Triad::gyro;
    if (!(triad == Triad::accel ? problem.sweep()->accel : problem.sweep()->gyro)) continue;
    const Matrix3d to_readings = triad_model(problem.model(), triad).matrix.inverse();
    const double per_K = problem.sweep()->per_K;
    const auto factor = [&](int order) { return 1 / (std::pow(per_K, order) * std::pow(second_order_per_first, order - 1)); };
    if (g.effect->name.ends_with(".matrix_thermal"))
      for (int column = 0; column < g.effect->basis; ++column) {
        const MatrixThermal m = matrix_thermal(triad, column);
        const Term term = m.order == 1 ? Term::matrix_thermal1 : Term::matrix_thermal2;
        if (!m.lags) add(coefficient_index(triad, term, m.row, m.column), g.first + column, VectorXd::Constant(1, -m.size() * factor(m.order)));
      }
    else
      for (int axis = 0; axis < 3; ++axis)
        for (int order = 1; order <= 3; ++order)
          add(coefficient_index(triad, Term::thermal, axis, order), g.first + 3 * (order - 1), factor(order) * to_readings.row(axis).transpose());
  }
  out.by_parameter.resize(std::ssize(rows), parameters);
  for (std::size_t i = 0; i < rows.size(); ++i) out.by_parameter.row(static_cast<Index>(i)) = rows[i].transpose();
  const auto by_effect = out.by_parameter.rightCols(effects.size());
  out.value = by_effect * effects.value();
  out.prior = (by_effect * effects.sigma().asDiagonal()).rowwise().norm();
  return out;
}

/// Returns the covariance of the coefficients, then of terms that are linear in all parameters.
Eigen::MatrixXd with_terms(const Eigen::MatrixXd& covariance, Index coefficients, const ThermalTerms& terms) {
  Eigen::MatrixXd by_parameter = Eigen::MatrixXd::Zero(coefficients + terms.by_parameter.rows(), covariance.rows());
  by_parameter.topLeftCorner(coefficients, coefficients).setIdentity();
  by_parameter.bottomRows(terms.by_parameter.rows()) = terms.by_parameter;
  return by_parameter * covariance * by_parameter.transpose();
}

}  // namespace

Eigen::MatrixXd raw_covariance(const RestProblem& problem, Eigen::MatrixXd covariance) {
  return raw_covariance_of(problem, problem.indices(), std::move(covariance));
}

VectorXd weakest_matrix_direction(const RestProblem& problem, const Eigen::MatrixXd& covariance) {
  std::vector<Index> at;
  for (std::size_t i = 0; i < problem.indices().size(); ++i)
    if (coefficient(problem.indices()[i]).term == Term::matrix) at.push_back(static_cast<Index>(i));
  if (at.empty()) return VectorXd::Zero(covariance.rows());
  const SymmetricEigen known = symmetric_eigen(covariance(at, at));
  return covariance(Eigen::all, at) * known.vectors.rightCols<1>() / std::sqrt(std::max(known.values[known.values.size() - 1], 1e-300));
}

Calibration calibration_of(std::string_view method, const RestProblem& problem, const Fit& fit, const Session& session) {
  Calibration out;
  out.imu = session.imu.name;
  out.method = method;
  std::vector<CoefficientIndex> indices = problem.indices();
  const std::size_t fitted = indices.size();
  const auto n = static_cast<Index>(fitted);
  const ThermalTerms thermal = thermal_terms(problem, fit.covariance().rows());
  Eigen::MatrixXd covariance = fit.excess * fit.excess * with_terms(fit.covariance(), n, thermal);
  auto [kept, implausible] = stated(problem, covariance, out.quality.findings);
  const VectorXd correction = implausible ? VectorXd(VectorXd::Zero(covariance.rows())) : with_unstated_at_prior(problem, kept, covariance);
  SensorModel scaled = problem.model();
  for (std::size_t k = 0; k < thermal.indices.size(); ++k) {
    // Terms that Dai's model lacks are stated if the data say more of them than their prior.
    const auto at = static_cast<Index>(k);
    const bool seen = std::sqrt(covariance(n + at, n + at)) <= 0.9 * thermal.prior[at];
    indices.push_back(thermal.indices[k]);
    kept.push_back(!implausible && (seen || !is_extended(coefficient(thermal.indices[k]))));
    set_coefficient(scaled, thermal.indices[k], thermal.value[at]);
    TriadModel& triad = coefficient(thermal.indices[k]).triad == Triad::accel ? scaled.accel : scaled.gyro;
    if (!implausible) triad.temperature = problem.sweep()->reading;
  }
  std::vector<Index> at;
  for (std::size_t i = 0; i < indices.size(); ++i) {
    const CoefficientIndex index = indices[i];
    const Coefficient& c = coefficient(index);
    const double value = coefficient_value(scaled, index) + correction[static_cast<Index>(i)];
    set_coefficient(scaled, index, kept[i] ? value : coefficient_value(problem.prior(), index));
    if (i < fitted && is_optional(c.term) && (!kept[i] || fit.parameters.role[i] == kernel::Role::considered))
      out.quality.considered.emplace_back(c.name);
    if (kept[i]) {
      at.push_back(static_cast<Index>(i));
      out.estimated.push_back(index);
    } else if (!is_optional(c.term)) {
      out.quality.unobservable.emplace_back(c.name);
    }
  }
  out.model = to_raw(scaled, problem.scaling());
  out.covariance = raw_covariance_of(problem, indices, covariance)(at, at);
  if (const Eigen::MatrixXd part = problem.effects().constant_part(fit.parameters, fit.covariance(), problem.indices()); part.size() > 0) {
    Eigen::MatrixXd constant = Eigen::MatrixXd::Zero(covariance.rows(), covariance.rows());
    constant.topLeftCorner(n, n) = part;
    out.constant_covariance = limited_part(raw_covariance_at_g(problem, indices, constant)(at, at), out.covariance);
  }
  const kernel::Solution& under_noise = fit.under_noise.solution;
  out.quality.degrees_of_freedom = static_cast<int>(std::lround(under_noise.degrees_of_freedom));
  out.quality.chi2_per_dof = under_noise.chi2 / std::max(1.0, under_noise.degrees_of_freedom);
  out.quality.condition = kernel::condition_number(fit.conditions.information(), fit.parameters);
  out.quality.sources.push_back(kernel::gravity_source(session.site));
  out.quality.converged = fit.converged;
  return out;
}

void add_parts(Quality& quality, const std::vector<SuspectRows>& parts, const Fit& fit, const std::vector<DroppedPart>& dropped) {
  for (const SuspectRows& part : parts)
    if (!part.rows.empty()) (part.rotation ? quality.rotations : quality.rests).push_back(part_residual(part, fit));
  for (const DroppedPart& part : dropped) (part.rotation ? quality.rotations : quality.rests).push_back(part.residual);
  for (std::vector<PartResidual>* all : {&quality.rests, &quality.rotations})
    std::sort(all->begin(), all->end(), [](const PartResidual& a, const PartResidual& b) { return a.begin_s < b.begin_s; });
}

std::vector<TermTest> test_terms(const RestProblem& problem, const Fit& fit, double significance) {
  std::vector<TermTest> tests;
  const Eigen::MatrixXd covariance = fit.covariance();
  const VectorXd values = coefficient_values(problem.model(), problem.indices());
  for (const char* name : {"accel.quadratic", "accel.cubic", "gyro.quadratic", "gyro.cubic", "gyro.g_sensitivity"}) {
    const std::vector<CoefficientIndex> term = select_coefficients(name);
    std::vector<Index> members;
    bool asked = false;
    for (std::size_t i = 0; i < problem.indices().size(); ++i) {
      if (!contains(term, problem.indices()[i])) continue;
      asked = true;
      if (fit.parameters.role[i] == kernel::Role::estimated) members.push_back(static_cast<Index>(i));
    }
    if (asked)
      tests.push_back(kernel::wald_without_prior(name, values(members), covariance(members, members), fit.parameters.sigma(members), significance));
  }
  return tests;
}

void add_findings(kernel::Findings& findings, const Calibration& calibration, const RestProblem& problem, const Fit& fit, double curvature,
                  const Site& site, const std::vector<std::string>& dropped, std::size_t all) {
  if (problem.effects().size() == 0) kernel::warn_of_larger_terms(findings, problem.effects().contradicting());
  kernel::note_spread(findings, "the rests' accelerometer means", fit.spreads[0] / unit::ug, "ug");
  kernel::note_spread(findings, "the rests' gyro means", fit.spreads[1] / unit::deg_per_h, "deg/h");
  kernel::note_spread(findings, "the rotations", fit.spreads[2] / unit::deg, "deg");
  kernel::add_scatter(findings, "residuals", fit.excess);
  kernel::doubt_improbable(findings, problem.effects(), fit.p_value);
  kernel::add_common_doubts(findings, calibration, site, problem.effects().degrees_of_freedom(fit.under_noise.solution.covariance));
  if (site.latitude) kernel::doubt_latitude(findings, calibration, *site.latitude, site.gravity());
  if (curvature > most_curvature) {
    findings.add<Code::large_misalignments>();
    findings.add<Code::uncertain_combinations>();
  }
  kernel::add_dropped(findings, dropped, all);
  constexpr double slow_s = 5 * thermometer_lag_s;
  if (const auto& sweep = problem.sweep(); sweep && (sweep->accel || sweep->gyro) && sweep->shortest_s < slow_s)
    findings.add<Code::fast_sweep>(sweep->range_K, sweep->shortest_s, slow_s);
  // The spread is enlarged for few degrees of freedom, but with fewer than five, errors of five sigmas occur (p = 0.002).
  if (const double degrees = fit.spread_degrees(); degrees < 5) findings.add<Code::uncertain_spread>(degrees);
}

}  // namespace imulab::rests
