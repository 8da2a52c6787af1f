// A case. A unit that moved by an arcminute half-way, on a table good to two arcseconds: the residuals are ten times what the table explains. A table
// that is ten times worse explains them, too, and so does, in part, an elastic mount. But of all patterns that a worse table can have, few look like
// one rotation from one step on: the readings are e^50 times more probable with it. Comparing probabilities of the same readings under different
// assumptions (restricted likelihood) decides without a rule for every pair. What has more freedom pays for it: a prior spreads its probability
// over all that it allows, and a choice among many steps costs the logarithm of their number.
#include "imulab/estimate/turntable/explanation.hpp"

#include "imulab/core/decomposition.hpp"
#include "imulab/estimate/kernel/prior.hpp"
#include "imulab/rig/table_states.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>

namespace imulab::turntable {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Logarithm of the ratio of probabilities from which on an explanation is believed, and by which two can be told apart.
constexpr double convincing = 5, told_apart = 3;

struct Candidate {
  enum class Kind { none, step, move, effect, term } kind = Kind::none;
  double evidence = 0;
  std::size_t place = 0;  ///< of a step among the parts, of a move among the steps, of a term among those with a prior
  kernel::Effects::Wider wider{};
};

struct TermPrior {
  std::string_view name;
  double& (*size)(kernel::PriorSizes&);
};
constexpr std::array<TermPrior, 5> term_priors{{{"accel.quadratic", [](kernel::PriorSizes& s) -> double& { return s.accel.quadratic; }},
                                                {"accel.cubic", [](kernel::PriorSizes& s) -> double& { return s.accel.cubic; }},
                                                {"gyro.quadratic", [](kernel::PriorSizes& s) -> double& { return s.gyro.quadratic; }},
                                                {"gyro.cubic", [](kernel::PriorSizes& s) -> double& { return s.gyro.cubic; }},
                                                {"gyro.g_sensitivity", [](kernel::PriorSizes& s) -> double& { return s.g_sensitivity; }}}};

using Widened = std::array<double, term_priors.size()>;  ///< by how much the priors of the terms were

/// The fit with its effects in the options, from which `contradicted` judges.
kernel::Effects found_effects(const Fit& fit) {
  kernel::Effects effects = fit.options.effects.table;
  effects.correct(fit.estimator.effects(fit.readings) - effects.value());
  return effects;
}

Candidate bad_step(const Fit& fit, double level) {
  const std::vector<double> log_p = fit.estimator.log_probabilities(fit.readings);
  const auto worst = static_cast<std::size_t>(std::min_element(log_p.begin(), log_p.end()) - log_p.begin());
  const double all = std::log(static_cast<double>(log_p.size()));
  if (log_p.empty() || !(log_p[worst] < std::log(level) - all) || !fit.may_drop(worst)) return {};
  return {Candidate::Kind::step, -log_p[worst] - all, worst};
}

/// The step before which a rotation of the unit in its mount explains most.
Candidate move(const Fit& fit, const kernel::EffectSizes& sizes) {
  const TableProblem& problem = *fit.problem;
  const std::size_t steps = problem.seen.parts.steps.size();
  if (fit.options.effects.moved_at || steps < 2) return {};
  const Effect& effect = *find_effect("mount.change");
  std::vector<MatrixXd> from(steps, MatrixXd::Zero(static_cast<Index>(6 * problem.motion.parts()), effect.basis));
  const auto states = table_states(problem.motion, problem.seen.parts, problem.site.gravity(), 0);
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
  const double sigma = effect_sigma(effect, sizes.declared, sizes.grade, sizes.accel_offset);
  const std::vector<Estimator::Score> scores = fit.estimator.scores(fit.readings, from);
  Candidate best;
  for (std::size_t step = 1; step < steps; ++step) {
    // ln of the mean, over the prior, of the ratio of the readings' probabilities.
    const SymmetricEigen V = symmetric_eigen(sigma * sigma * scores[step].V);
    const VectorXd s = sigma * V.vectors.transpose() * scores[step].s;
    double evidence = -std::log(static_cast<double>(steps - 1));
    for (Index i = 0; i < s.size(); ++i) {
      const double information = std::max(V.values[i], 0.0);
      evidence += 0.5 * (s[i] * s[i] / (1 + information) - std::log1p(information));
    }
    if (evidence > best.evidence) best = {Candidate::Kind::move, evidence, step};
  }
  return best;
}

std::vector<Candidate> large_effects(const Fit& fit) {
  std::vector<Candidate> out;
  for (const kernel::Effects::Wider& wider : found_effects(fit).contradicted(fit.estimator.effects_covariance()))
    out.push_back({Candidate::Kind::effect, wider.evidence, wider.group, wider});
  return out;
}

std::vector<Candidate> large_terms(const Fit& fit, const Widened& widened) {
  if (!fit.options.optional) return {};
  const Estimator::Uncertainty uncertainty = fit.estimator.uncertainty(fit.model);
  const VectorXd values = coefficient_values(fit.model, uncertainty.stated), priors = fit.estimator.prior_sigma(fit.model, uncertainty.stated);
  std::vector<Candidate> out;
  for (std::size_t k = 0; k < term_priors.size(); ++k) {
    const std::vector<CoefficientIndex> of_term = select_coefficients(std::string(term_priors[k].name));
    std::vector<Index> members;
    for (std::size_t i = 0; i < uncertainty.stated.size(); ++i)
      if (contains(of_term, uncertainty.stated[i]) && !contains(uncertainty.considered, uncertainty.stated[i]))
        members.push_back(static_cast<Index>(i));
    if (members.empty()) continue;
    const VectorXd value = values(members), prior = priors(members);
    const MatrixXd covariance = uncertainty.covariance(members, members);
    const double wanted = kernel::widening(value, prior, covariance), evidence = kernel::evidence_of_wider(value, prior, covariance, wanted);
    if (wanted > 1) out.push_back({Candidate::Kind::term, evidence, k, {k, std::min(wanted, kernel::Effects::most_widening / widened[k]), evidence}});
  }
  return out;
}

std::string name_of(const Candidate& c, const Fit& fit) {
  if (c.kind == Candidate::Kind::term) return std::string(term_priors[c.place].name);
  return c.kind == Candidate::Kind::move ? "mount.change" : std::string(fit.options.effects.table.groups()[c.place].effect->name);
}

/// All that explains something, the best first. A bad step, which may be off by anything, explains whatever one pair of turns shows of an effect: it
/// is left out where that is convincingly better than any prior that can still be widened.
std::vector<Candidate> candidates(const Fit& fit, const kernel::EffectSizes& sizes, const Widened& widened, double level) {
  std::vector<Candidate> all = large_effects(fit);
  for (const Candidate& c : large_terms(fit, widened)) all.push_back(c);
  for (const Candidate& c : {bad_step(fit, level), move(fit, sizes)})
    if (c.kind != Candidate::Kind::none) all.push_back(c);
  std::stable_sort(all.begin(), all.end(), [](const Candidate& a, const Candidate& b) { return a.evidence > b.evidence; });
  const auto rival = std::find_if(all.begin(), all.end(), [](const Candidate& c) { return c.kind != Candidate::Kind::step && c.wider.factor > 1; });
  if (rival != all.end() && all.front().kind == Candidate::Kind::step && rival->evidence > all.front().evidence - convincing)
    std::rotate(all.begin(), rival, rival + 1);
  return all;
}

/// Takes the best, and widens the priors of all that cannot be told apart from it: the uncertainties cover what the coefficients differ by among
/// them. Whether anything changed.
bool take(Explained& out, EstimatorOptions& options, Widened& widened, const std::vector<Candidate>& all, const kernel::EffectSizes& sizes) {
  const auto add_once = [](std::vector<std::string>& names, const std::string& name) {
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  };
  const Candidate& best = all.front();
  if (best.kind == Candidate::Kind::step) {
    out.dropped.push_back(out.fit.suspects()[best.place].name);
    options.left_out.push_back(best.place);
    return true;
  }
  const TableProblem& problem = *out.fit.problem;
  bool changed = false;
  for (const Candidate& c : all) {
    if (c.kind == Candidate::Kind::step || !(c.evidence > best.evidence - told_apart)) continue;
    const std::string name = name_of(c, out.fit);
    add_once(out.causes, name);
    if (!(c.wider.factor > 1)) continue;  // as wide as it may be
    changed = true;
    if (c.kind == Candidate::Kind::effect) options.effects.table.widen(c.wider);
    if (c.kind != Candidate::Kind::term) continue;
    term_priors[c.place].size(*options.optional) *= c.wider.factor;
    widened[c.place] *= c.wider.factor;
    add_once(out.widened, name);
  }
  if (best.kind != Candidate::Kind::move) return changed;
  options.effects = with_move(options.effects, best.place, sizes, problem.motion, problem.seen.parts, problem.site);
  return true;
}

}  // namespace

Explained explained(const Fit& fit_with_effects, const kernel::EffectSizes& sizes, double level) {
  constexpr int most_rounds = 20;
  Explained out{fit_with_effects, {}, {}, {}, {}, false};
  Widened widened;
  widened.fill(1);
  for (int round = 0; round < most_rounds; ++round) {
    const Fit& now = out.fit;
    const TableProblem& problem = *now.problem;
    const std::vector<Candidate> all = candidates(now, sizes, widened, level);
    const Candidate best = all.empty() ? Candidate{} : all.front();
    const Fit larger = enlarged(now, kernel::Effects::most_widening);
    const double of_size = larger.estimator.log_likelihood(larger.readings) - now.estimator.log_likelihood(now.readings);
    if (of_size > std::max(best.evidence, convincing)) {
      out.by_size = true;
      for (const Candidate& c : all)
        if (c.kind == Candidate::Kind::step) out.worst = now.suspects()[c.place].name;
      break;
    }
    if (!(best.evidence > convincing)) break;
    EstimatorOptions options = now.options;
    if (!take(out, options, widened, all, sizes)) break;
    out.fit = fit(problem, options);
  }
  return out;
}

}  // namespace imulab::turntable
