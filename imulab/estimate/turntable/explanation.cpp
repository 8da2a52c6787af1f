// An example. A unit moves by an arcminute halfway through, on a table accurate to two arcseconds: the residuals are ten times what the table
// explains. A table with ten times larger errors would also explain them, and an elastic mount would in part. But few of the error patterns of such a
// table resemble one rotation at one step, so the readings are e^50 times more probable with that rotation. The probabilities of the same readings
// under different assumptions (restricted likelihood) decide without a rule for every pair. More freedom has its price: a prior spreads its
// probability over all that it allows, and a choice among many steps costs the logarithm of their number.
#include "imulab/estimate/turntable/explanation.hpp"

#include "imulab/core/decomposition.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/rig/table_states.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace imulab::turntable {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Logarithm of the ratio of probabilities above which an explanation is accepted.
constexpr double convincing = 5;
/// Largest factor on declared noise and table errors that is considered as an explanation.
constexpr double most_enlarged = 4;

struct Candidate {
  enum class Kind { none, step, change } kind = Kind::none;
  double evidence = 0;
  std::size_t place = 0;  ///< index of a bad step among the parts, or of a change among the steps
  const Effect* effect = nullptr;
};

Candidate bad_step(const Fit& fit, double level) {
  const std::vector<double> log_p = fit.estimator.log_probabilities(fit.readings);
  if (log_p.empty()) return {};
  const auto worst = static_cast<std::size_t>(std::min_element(log_p.begin(), log_p.end()) - log_p.begin());
  const double all = std::log(static_cast<double>(log_p.size()));
  if (!(log_p[worst] < std::log(level) - all) || !fit.may_drop(worst)) return {};
  return {Candidate::Kind::step, -log_p[worst] - all, worst};
}

/// Returns the step before which a change of one kind explains most.
Candidate change_of(const Effect& effect, const Fit& fit, const kernel::EffectSizes& sizes, const std::vector<std::vector<WeightedState>>& states) {
  const TableProblem& problem = *fit.problem;
  const std::size_t steps = problem.seen.parts.steps.size();
  std::vector<MatrixXd> from(steps, MatrixXd::Zero(static_cast<Index>(6 * problem.motion.parts()), effect.basis));
  for (std::size_t part = 0; part < states.size(); ++part)
    for (const auto& [state, weight, attitude] : states[part])
      for (int column = 0; column < effect.basis; ++column) {
        const OutputChange change = effect.phi(state, column);
        for (std::size_t step = 1; step <= problem.motion.step(part); ++step) {
          auto sum = from[step].col(column).segment<6>(static_cast<Index>(6 * part));
          if (problem.motion.is_hold(part)) sum.head<3>() += weight * change.force;
          sum.tail<3>() += weight * change.rate;
        }
      }
  const double sigma = sizes.of(effect);
  const std::vector<Estimator::Score> scores = fit.estimator.scores(fit.readings, from);
  Candidate best;
  for (std::size_t step = 1; step < steps; ++step) {
    // Compute ln of the mean, over the prior, of the ratio of the readings' probabilities.
    const SymmetricEigen V = symmetric_eigen(sigma * sigma * scores[step].V);
    const VectorXd s = sigma * V.vectors.transpose() * scores[step].s;
    double evidence = -std::log(static_cast<double>(steps - 1));
    for (Index i = 0; i < s.size(); ++i) {
      const double information = std::max(V.values[i], 0.0);
      evidence += 0.5 * (s[i] * s[i] / (1 + information) - std::log1p(information));
    }
    if (evidence > best.evidence) best = {Candidate::Kind::change, evidence, step, &effect};
  }
  return best;
}

/// Returns the most probable change of the unit or its mount; only one is considered.
Candidate change(const Fit& fit, const kernel::EffectSizes& sizes) {
  const TableProblem& problem = *fit.problem;
  Candidate best;
  if (fit.options.effects.change || problem.seen.parts.steps.size() < 2) return best;
  const auto states = table_states(problem.motion, problem.seen.parts, problem.site.gravity(), 0);
  double kinds = 0;
  for (const Effect& effect : effects()) {
    if ((effect.needs & Effect::by_change) == 0 || !(sizes.of(effect) > 0)) continue;
    kinds += 1;
    if (const Candidate one = change_of(effect, fit, sizes, states); one.evidence > best.evidence) best = one;
  }
  best.evidence -= std::log(std::max(1.0, kinds));
  return best;
}

/// Coefficients and effects of a fit, about its model.
struct Joint {
  std::vector<CoefficientIndex> coefficients;
  kernel::Parameters parameters;
  kernel::Solution solution;

  explicit Joint(const Fit& fit) {
    const Estimator::Uncertainty found = fit.estimator.uncertainty(fit.model);
    coefficients = found.stated;
    const Index n = std::ssize(coefficients), m = fit.options.effects.table.size();
    parameters = kernel::Parameters(n + m);
    for (std::size_t i = 0; i < coefficients.size(); ++i)
      if (!fit.options.optional || contains(found.considered, coefficients[i])) parameters.role[i] = kernel::Role::considered;
    parameters.offset << -coefficient_values(fit.model, coefficients), -fit.estimator.effects(fit.readings);
    parameters.sigma << fit.estimator.prior_sigma(fit.model, coefficients), fit.options.effects.table.sigma();
    solution.x.setZero(n + m);
    solution.covariance = joint_covariance(fit, coefficients, found.covariance);
  }
};

/// Returns the log ratio of the data's probability with effects of any size to that with the sizes in use.
double gain_of_sizes(const Fit& fit) {
  const Joint joint(fit);
  kernel::Effects sized = fit.options.effects.table;
  sized.infer(joint.parameters, joint.solution, joint.coefficients);
  return sized.log_gain_over_before(fit.chi2);
}

}  // namespace

Fit with_inferred_sizes(Fit now) {
  constexpr int most_rounds = 4;
  for (int round = 0; round < most_rounds; ++round) {
    EstimatorOptions options = now.options;
    const Joint joint(now);
    kernel::Effects& effects = options.effects.table;
    if (!effects.infer(joint.parameters, joint.solution, joint.coefficients)) break;
    if (options.optional) options.optional = effects.terms();
    now = fit(*now.problem, options);
  }
  return now;
}

double p_value(const Fit& fit) {
  const Joint joint(fit);
  const double cost = fit.chi2 + fit.options.effects.table.cost_of_limits(joint.parameters, joint.solution, joint.coefficients);
  return chi_square_tail(cost, std::max(1, fit.estimator.degrees_of_freedom()));
}

Eigen::MatrixXd joint_covariance(const Fit& fit, const std::vector<CoefficientIndex>& coefficients, const MatrixXd& covariance) {
  const Estimator& estimator = fit.estimator;
  const Index n = covariance.rows(), m = fit.options.effects.table.size();
  MatrixXd joint(n + m, n + m);
  joint.topLeftCorner(n, n) = covariance;
  joint.topRightCorner(n, m) =
      -estimator.sensitivity(fit.model, coefficients) * estimator.readings_by_effects() * estimator.effects_sigma().cwiseAbs2().asDiagonal();
  joint.bottomLeftCorner(m, n) = joint.topRightCorner(n, m).transpose();
  joint.bottomRightCorner(m, m) = estimator.effects_covariance();
  return joint;
}

Explained explained(const Fit& with_expected_sizes, const kernel::EffectSizes& sizes, double level) {
  constexpr int most_rounds = 20;
  Explained out{with_expected_sizes, {}, {}, false};
  Fit expected = with_expected_sizes;
  for (int round = 0; round < most_rounds; ++round) {
    const TableProblem& problem = *expected.problem;
    const Candidate step = bad_step(expected, level), changed = change(expected, sizes), best = step.evidence > changed.evidence ? step : changed;
    if (best.kind == Candidate::Kind::none || best.evidence < convincing) break;
    EstimatorOptions options = expected.options;
    if (best.kind == Candidate::Kind::step)
      options.left_out.push_back(best.place);
    else
      options.effects = table_effects(sizes, problem.motion, problem.seen.parts, problem.site, UnitChange{best.place, best.effect});
    Fit next = fit(problem, options);
    if (best.evidence + gain_of_sizes(next) < convincing + gain_of_sizes(expected)) break;
    const Fit larger = enlarged(expected, most_enlarged);
    if (larger.estimator.log_likelihood(larger.readings) - expected.estimator.log_likelihood(expected.readings) > best.evidence) break;
    if (best.kind == Candidate::Kind::step) out.dropped.push_back(expected.suspects()[best.place].name);
    expected = std::move(next);
  }
  out.fit = with_inferred_sizes(std::move(expected));
  const Fit& now = out.fit;
  const Fit larger = enlarged(now, most_enlarged);
  out.by_size = larger.estimator.log_likelihood(larger.readings) - now.estimator.log_likelihood(now.readings) > convincing;
  if (const Candidate step = bad_step(now, level); out.by_size && step.kind == Candidate::Kind::step) out.worst = now.suspects()[step.place].name;
  return out;
}

}  // namespace imulab::turntable
