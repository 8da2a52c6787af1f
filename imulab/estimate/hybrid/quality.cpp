#include "imulab/estimate/hybrid/quality.hpp"

#include "imulab/core/decomposition.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/estimate/hybrid/turns.hpp"
#include "imulab/estimate/kernel/effect_findings.hpp"
#include "imulab/recording/compensated_readings.hpp"
#include "imulab/units.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace imulab::hybrid {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Returns the degrees of freedom of the velocities in the last pass.
int degrees_of_freedom(const Data& data, const Iterate& iterate) {
  double estimated = static_cast<double>((iterate.states.prior.array() > 0).count());
  if (iterate.pass.effects.value.size() > 0) estimated += data.unmodeled.effects.degrees_of_freedom(iterate.pass.effects.covariance);
  return static_cast<int>(static_cast<double>(3 * data.observed() + std::ssize(iterate.pass.headings)) - estimated);
}

/// Adjacent blocks that were left out together.
struct Disturbance {
  std::size_t first, last;
};

std::vector<Disturbance> disturbances(std::vector<std::size_t> left_out) {
  std::sort(left_out.begin(), left_out.end());
  std::vector<Disturbance> out;
  for (const std::size_t k : left_out) {
    if (out.empty() || k > out.back().last + 1) out.push_back({k, k});
    out.back().last = k;
  }
  return out;
}

/// Bumps occur at any time; disturbances concentrated in turns indicate a term that the model lacks.
void judge_left_out(const Data& data, const std::vector<Disturbance>& found, kernel::Findings& findings) {
  constexpr double improbable = 1e-4;
  double turning = 0, observed = 0, in_turns = 0;
  for (const Block& block : data.blocks) observed += 1, turning += !block.at_rest;
  for (const Disturbance& d : found) in_turns += !data.blocks[d.first].at_rest;
  const double n = static_cast<double>(found.size());
  if (turning == 0 || binomial_quantile(1 - improbable, n, turning / observed) >= in_turns) return;
  findings.add<Code::disturbances_in_turns>(in_turns, n);
}

/// Lists the blocks that were left out, with their times.
void add_left_out(const Data& data, const std::vector<std::size_t>& left_out, kernel::Findings& findings) {
  if (left_out.empty()) return;
  constexpr std::size_t most_listed = 10;
  const std::vector<Disturbance> found = disturbances(left_out);
  std::string times;
  for (std::size_t k = 0; k < std::min(found.size(), most_listed); ++k)
    times += fmt::format("{}{:.1f}..{:.1f} s", k == 0 ? "" : ", ", data.recording.time_s(data.blocks[found[k].first].samples.begin),
                         data.recording.time_s(data.blocks[found[k].last].samples.end - 1));
  if (found.size() > most_listed) times += fmt::format(" and {} more", found.size() - most_listed);
  findings.add<Code::velocities_left_out>(left_out.size(), data.blocks.size(), times);
  judge_left_out(data, found, findings);
}

/// Checks whether innovations are white: with white noise of any size they are, but an incomplete model correlates them long before it increases
/// their size. Late stamps, differently shaped slow noise and a delay give correlations up to 0.12 with correct uncertainties.
void judge_whiteness(const Iterate& iterate, kernel::Findings& findings) {
  constexpr double much = 0.15, improbable = 5;  // in standard deviations of white innovations: p = 3e-7
  const auto [correlation, sigma] = iterate.pass.serial;
  if (!iterate.converged || correlation < std::max(much, improbable * sigma)) return;
  findings.add<Code::colored_residuals>(correlation);
}

/// The force along up at a rest, and its derivative with respect to the effects.
struct RestForce {
  Vector3d force = Vector3d::Zero();  // mean, in body axes
  double duration = 0;                // s
  Eigen::RowVectorXd by_effect = {};
};

std::vector<RestForce> rests_of(const Data& data, const Iterate& last) {
  CompensatedReadings readings(data.recording, last.about.model);
  kernel::Effects effects = data.unmodeled.effects;
  if (last.pass.effects.value.size() > 0) effects.correct(last.pass.effects.value);
  std::vector<RestForce> rests;
  bool new_rest = true;
  for (std::size_t k = 0; k < data.blocks.size(); ++k) {
    const Block& block = data.blocks[k];
    new_rest = new_rest || !block.at_rest || block.lost;
    if (!block.at_rest || !block.observed) continue;
    if (std::exchange(new_rest, false)) rests.emplace_back().by_effect.setZero(effects.size());
    RestForce& rest = rests.back();
    const double dt = data.recording.interval_s, duration = dt * static_cast<double>(block.samples.size());
    for (std::size_t i = block.samples.begin; i < block.samples.end; ++i) rest.force += dt * readings.force(i);
    rest.duration += duration;
    if (effects.size() == 0) continue;
    const EffectState& state = last.pass.states[k];
    rest.force -= duration * effects.output(state).force;
    const Vector3d up = state.force.normalized();
    for (Index c = 0; c < effects.size(); ++c) rest.by_effect[c] += duration * up.dot(effects.columns()[static_cast<std::size_t>(c)].at(state).force);
  }
  for (RestForce& rest : rests) rest.force /= rest.duration, rest.by_effect /= rest.duration;
  return rests;
}

/// Detects offsets or scales that change from rest to rest while the velocities within each rest fit: the force is not g everywhere. Returns the
/// scatter of the rests' forces about their mean, relative to white noise and to the uncertainty of the effects that were removed. Declared slow
/// noise disables this check.
double drift_between_rests(const Data& data, const Iterate& last) {
  const std::vector<RestForce> rests = rests_of(data, last);
  const Index n = std::ssize(rests);
  if (n < 2 || data.noise.accel_slow.any()) return 1;
  VectorXd values(n), noise(n);
  const MatrixXd& of_effects = last.pass.effects.covariance;
  MatrixXd by_effect(n, of_effects.cols());
  for (Index k = 0; k < n; ++k) {
    const RestForce& rest = rests[static_cast<std::size_t>(k)];
    values[k] = rest.force.norm(), noise[k] = data.noise.accel.cwiseAbs2().mean() / rest.duration, by_effect.row(k) = rest.by_effect;
  }
  MatrixXd covariance = by_effect * of_effects * by_effect.transpose();
  covariance.diagonal() += noise;
  const VectorXd weight = solve_semidefinite(covariance, VectorXd(VectorXd::Ones(n)));
  values.array() -= weight.dot(values) / weight.sum();
  return kernel::excess(squared_norm_in(covariance, values), static_cast<double>(n) - 1);
}

/// Drift from rest to rest beyond which a result is doubtful, as for residuals and scatter in all methods.
constexpr double much_drift = 5;

/// Reports the scatter of headings, which is part of their weight (noise_of_angle).
void judge_headings(double scatter, kernel::Findings& findings) {
  if (scatter <= 1) return;
  findings.add<Code::headings_scatter>(scatter).severity = scatter > much_drift ? Severity::doubt : Severity::warning;
}

/// Enlarges the uncertainties if the velocities scatter more than their noise.
void enlarge(const Data& data, const Iterate& iterate, Calibration& calibration, kernel::Findings& findings) {
  const auto excess_of = [&](auto counts) {
    double chi2 = 0, degrees = 0;
    for (std::size_t k = 0; k < data.blocks.size(); ++k)
      if (data.blocks[k].observed && counts(data.blocks[k])) chi2 += iterate.pass.chi2[k], degrees += 3;
    return kernel::excess(chi2, degrees);
  };
  double factor = excess_of([](const Block& b) { return b.at_rest; });
  // Ramps shorter than two samples cause a few percent; half as much again exceeds that.
  if (const double in_turns = excess_of([](const Block& b) { return !b.at_rest; }); in_turns > 1.5) factor = std::max(factor, in_turns);
  if (const double drift = drift_between_rests(data, iterate); drift > factor) {
    constexpr double much_of_velocities = 1.5;
    findings.add<Code::forces_scatter>(drift).severity = drift > much_drift || factor > much_of_velocities ? Severity::doubt : Severity::warning;
    factor = drift;
  } else {
    kernel::add_scatter(findings, "velocities", factor);
  }
  calibration.covariance *= factor * factor;
}

/// Considers coefficients that are not observable. Cubic terms resemble scales at the forces and rates of the data. Quadratic gyro terms, which turns
/// in both directions separate from scales, resemble no other term. Both enter the covariance of the scales.
void consider_nonlinearity(const Data& data, Calibration& c) {
  std::vector<double> rates;
  for (const Block& block : data.blocks)
    if (!block.at_rest)
      for (std::size_t k = 0; k < 3; ++k) rates.push_back(std::abs(data.recording.gyro[k][block.samples.begin]));
  const double force = data.place.gravity, rate = rates.empty() ? 0 : quantile(rates, 0.9) * std::cbrt(std::abs(c.model.gyro.matrix.determinant()));
  for (const char* selector : {"accel.cubic", "gyro.quadratic", "gyro.cubic"})
    for (const CoefficientIndex index : select_coefficients(selector)) {
      const Coefficient& term = coefficient(index);
      const TriadModel& triad = triad_model(c.model, term.triad);
      const double scale = std::abs(triad.matrix(term.row, term.row)), reading = (term.triad == Triad::accel ? force : rate) / scale;
      const CoefficientIndex slope = coefficient_index(term.triad, Term::matrix, term.row, term.row);
      const auto at = std::find(c.estimated.begin(), c.estimated.end(), slope);
      if (at == c.estimated.end()) continue;
      const double sigma = kernel::prior_sigma(data.terms.priors.sizes, term, scale), effect = term.term == Term::cubic ? reading * reading : reading;
      const Index row = at - c.estimated.begin(), n = c.covariance.rows();
      for (MatrixXd* const m : {&c.covariance, &c.constant_covariance}) {  // a term of the unit
        if (m->size() == 0) continue;
        m->conservativeResize(n + 1, n + 1);
        m->row(n).setZero(), m->col(n).setZero();
        (*m)(n, n) = sigma * sigma;
        (*m)(row, row) += std::pow(sigma * effect, 2);
        if (term.term == Term::cubic) (*m)(row, n) = (*m)(n, row) = -sigma * sigma * effect;
      }
      c.estimated.push_back(index);
      c.quality.considered.emplace_back(term.name);
    }
}

}  // namespace

Calibration calibration_of(const Data& data, const Iterate& iterate) {
  const Errors errors = determined_errors(iterate);
  Calibration c;
  c.method = "hybrid";
  c.model = with_mean_offsets(iterate.about.model, errors.mean, iterate.states);
  c.estimated = errors.coefficients;
  for (const CoefficientIndex index : errors.considered) c.quality.considered.emplace_back(coefficient(index).name);
  for (const CoefficientIndex index : errors.open) {
    c.quality.unobservable.emplace_back(coefficient(index).name);
    set_coefficient(c.model, index, coefficient_value(data.coarse, index));
  }
  const MatrixXd jacobian = correction_jacobian(iterate.about.model, c.estimated, iterate.states);
  c.covariance = jacobian * errors.covariance * jacobian.transpose();
  if (!c.estimated.empty()) c.quality.condition = kernel::condition_number(c.covariance);
  c.quality.degrees_of_freedom = degrees_of_freedom(data, iterate);
  const MatrixXd constant = constant_part(data, iterate);
  if (constant.size() > 0) c.constant_covariance = limited_part(jacobian * constant * jacobian.transpose(), c.covariance);
  if (data.terms.wanted.empty()) consider_nonlinearity(data, c);
  return c;
}

void report(const Data& data, const Converged& result, const Site& site, Calibration& calibration, kernel::Findings& findings) {
  const Iterate& last = result.last;
  const auto sigma = [&](Index state) { return std::sqrt(last.pass.covariance(state, state)); };
  calibration.quality.chi2_per_dof = (last.pass.total_chi2() + last.pass.chi2_of_headings()) / std::max(1, calibration.quality.degrees_of_freedom);
  enlarge(data, last, calibration, findings);
  judge_headings(result.headings, findings);
  calibration.quality.term_tests = result.tests;
  calibration.quality.converged = last.converged;
  calibration.quality.sources.push_back(kernel::gravity_source(site));
  if (data.unmodeled.size() == 0) kernel::warn_of_larger_terms(findings, data.unmodeled.effects.contradicting());
  judge_whiteness(last, findings);
  kernel::add_dropped(findings, result.lost, result.lost.size() + motions_of(data.blocks).size(), "rotations");
  add_left_out(data, result.left_out, findings);
  findings.add<Code::iterations>(last.iterations, data.blocks.size());
  if (const Index at = last.states.first(Group::delay); at >= 0) {
    const double delay = last.pass.x[at];
    findings.add<Code::triads_delayed>(1e3 * delay, 1e3 * sigma(at));
    constexpr double most = 1.5;  // samples: the equations are linear in the delay
    if (std::abs(delay) > most * data.recording.interval_s + 3 * sigma(at)) findings.add<Code::delay_too_large>(1e3 * delay);
  }
  kernel::add_common_doubts(findings, calibration, site);
  kernel::doubt_latitude(findings, calibration, last.about.place.latitude, last.about.place.gravity);
}

void add_effects(const Data& data, const Iterate& last, Calibration& calibration, kernel::Findings& findings) {
  const Separation::Estimate& estimate = last.pass.effects;
  if (estimate.value.size() == 0) return;
  kernel::Effects effects = data.unmodeled.effects;
  effects.correct(estimate.value);
  kernel::add_effects(calibration, findings, effects, estimate.covariance, 1e-3);
}

}  // namespace imulab::hybrid
