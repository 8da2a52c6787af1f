// The problem. Only gravity and the Earth's rate are known for a unit that was turned by hand, so no reading has a known input. The coefficients x
// and the mean readings v of rests satisfy conditions F(x, v) = 0, for example |A1 v + A0| = g. The error of a condition is the noise of its readings
// times its derivative with respect to them, which depends on x. Two more things are unknown: whether a mean has only the noise of its samples (a
// hand trembles, an offset changes from rest to rest), and which rests are bad.
//
// A small example. One axis points up, down and up again. Its means are v1 = 9.910, v2 = -9.710 and v3 = 9.930 m/s^2, each with a standard deviation
// of 0.001 from the noise of the samples, and g = 9.810. The conditions are
//
//     k v1 + b - g = 0,   -(k v2 + b) - g = 0,   k v3 + b - g = 0.
//
// Least squares gives k = 2g / (9.920 + 9.710) = 0.99949 and b = -0.105. The second condition is satisfied; the others have errors of -0.010 and
// +0.010. With one degree of freedom, chi-square is 2 (0.010 / 0.001)^2 = 200, far beyond chance. Either the means have an additional spread of about
// 0.014, and b has an uncertainty of 0.009 instead of 0.0006, or one rest is bad. Three rests cannot distinguish these cases. Twenty can: a bad rest
// deviates alone, a spread affects all.
//
// A fit therefore has three nested loops:
// - `converge`: Gauss-Newton steps under the current spreads; then the spread of each kind of condition is estimated, until both converge.
// - `converge_with_sizes`: effects and optional terms get priors of the sizes that the data imply.
// - SuspectFit: the worst suspect is tested against the fit without it, because a spread estimated with it would grow until the suspect fits. The
//   test allows for the few degrees of freedom of a spread (F distribution) and for the number of suspects.
// Finally, `fit_determined` sets optional terms that the data do not determine to zero, considered.
//
// A Problem is a RestProblem with conditions(spreads), parameters(), longest_step(), correct(correction), suspects(conditions), drop(suspect).
#pragma once

#include "imulab/core/decomposition.hpp"
#include "imulab/error.hpp"
#include "imulab/estimate/kernel/fit.hpp"
#include "imulab/estimate/rests/problem.hpp"
#include "imulab/grade.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>

namespace imulab::rests {

struct Fit {
  Conditions conditions{0, 0};
  kernel::Parameters parameters;
  Adjustment adjustment;
  Adjustment under_noise{};  ///< result of `fit_determined` with the sample noise alone
  Spreads spreads{};
  double p_value = 1;  ///< from Effects::p_value
  double excess = 1;   ///< ratio of the residuals to their size with the spreads, if significant; else 1
  bool converged = false;

  /// Returns the covariance, including the effect of considered parameters on the others.
  Eigen::MatrixXd covariance() const { return kernel::solve(conditions.information(), parameters, "the rests").covariance; }
  /// Returns the smallest degrees of freedom of the spreads in use; infinite if there are none.
  double spread_degrees() const {
    double degrees = std::numeric_limits<double>::infinity();
    for (int k = 0; k < kinds; ++k)
      if (spreads[static_cast<std::size_t>(k)] > 0) degrees = std::min(degrees, redundancy(conditions, adjustment, static_cast<Kind>(k)));
    return degrees;
  }
};

/// Returns one standard deviation along the least determined combination of the matrix elements, with the reaction of the other parameters.
Eigen::VectorXd weakest_matrix_direction(const RestProblem& problem, const Eigen::MatrixXd& covariance);

/// Iterates Gauss-Newton steps until every correction is below 1 % of its standard deviation. If the residuals of a kind are then significantly too
/// large, repeats this with that kind's spread until the spreads converge, or with the spreads `kept`. Steps longer than `longest_step` are shortened
/// to keep the linearization of poor data near the solution.
template <class Problem>
Fit converge(Problem& problem, const std::optional<Spreads>& kept = {}) {
  constexpr int most_iterations = 30, most_before_spreads = 8;
  Fit fit;
  fit.spreads = kept.value_or(Spreads{});
  bool decided = kept.has_value();
  fit.converged = kernel::iterate(most_iterations, [&](int iteration) {
    fit.conditions = problem.conditions(fit.spreads);
    fit.parameters = problem.parameters();
    fit.adjustment = adjust(fit.conditions, fit.parameters);
    const Eigen::VectorXd& x = fit.adjustment.solution.x;
    problem.correct(x / std::max(1.0, x.cwiseQuotient(problem.longest_step()).cwiseAbs().maxCoeff()));
    bool small = kernel::is_small(x, fit.adjustment.solution.covariance.diagonal().cwiseSqrt());
    if (!decided && !small && iteration < most_before_spreads) return kernel::Progress::moving;
    for (int k = 0; k < kinds && !kept; ++k) {
      const auto kind = static_cast<Kind>(k);
      double& spread = fit.spreads[static_cast<std::size_t>(k)];
      if (spread == 0 && (decided || !spread_is_significant(fit.conditions, fit.adjustment, kind))) continue;
      const double before = std::exchange(spread, estimate_spread(fit.conditions, fit.adjustment, kind, spread));
      small = small && std::abs(spread - before) <= 0.02 * std::max(spread, before);
    }
    decided = true;
    return small ? kernel::Progress::converged : kernel::Progress::moving;
  });
  return fit;
}

/// Returns the change of the solution, in chi-square, if it is linearized one standard deviation away along the least determined combination of the
/// matrix elements. Products of elements are nonlinear: if misalignments of 1e-3 are not determined, combinations known to 1e-6 change.
template <class Problem>
double curvature(Problem problem, const Fit& fit) {
  const Eigen::MatrixXd& covariance = fit.adjustment.solution.covariance;
  Eigen::VectorXd away = weakest_matrix_direction(problem, covariance);
  problem.correct(away);
  away += adjust(problem.conditions(fit.spreads), problem.parameters()).solution.x;
  return squared_norm_in(covariance, away);
}
/// Largest permitted curvature, for one coefficient. Beyond it, the total chi-square no longer agrees with the covariance.
inline constexpr double most_curvature = 1;

/// Infers the sizes of effects and optional terms from a fit, and fits again. Without effects, terms keep their expected sizes unless the data
/// contradict one. That is ignored if the equations are nonlinear within the uncertainties: second-order misalignment residuals mimic terms.
template <class Problem>
Fit with_inferred_sizes(Problem& problem, Fit fit) {
  constexpr int most_rounds = 5;
  const bool with_effects = problem.effects().size() > 0;
  for (int round = 0; round < most_rounds; ++round) {
    const kernel::Parameters parameters = problem.parameters();
    kernel::Effects sized = problem.effects();
    const bool changed = sized.infer(parameters, adjust(problem.conditions(fit.spreads), parameters).solution, problem.indices());
    if (!changed || (!with_effects && (sized.contradicting().empty() || curvature(problem, fit) > most_curvature))) break;
    problem.take_sizes(std::move(sized));
    fit = converge(problem);
  }
  return fit;
}

/// Returns the log probability of the data, averaged over the priors of coefficients, effects and effect sizes.
template <class Problem>
double log_probability(Problem& problem, const Fit& fit) {
  const Conditions conditions = problem.conditions(fit.spreads);
  return kernel::log_probability(conditions.information(), problem.parameters(), "the rests") - 0.5 * conditions.log_determinant() +
         problem.effects().log_gain();
}

/// Residuals beyond the noise can come from effects or from spreads, and each hides the other. Starts with both and keeps the more probable result.
template <class Problem>
Fit converge_with_sizes(Problem& problem) {
  Problem by_effects = problem;
  Fit fit = with_inferred_sizes(problem, converge(problem));
  if (problem.effects().size() == 0 || fit.spreads == Spreads{}) return fit;
  Fit other = with_inferred_sizes(by_effects, converge(by_effects, Spreads{}));
  if (!(log_probability(by_effects, other) > log_probability(problem, fit))) return fit;
  problem = std::move(by_effects);
  return other;
}

/// Computes the predictive test. Offsets may vary between rests by four times the grade's bias instability, turns by the accuracy of a hand.
template <class Problem>
double p_value(Problem& problem, Spreads spreads) {
  constexpr double most = 4;
  const kernel::Effects& effects = problem.effects();
  if (effects.size() == 0) return 1;
  const Grade& unit = grade(effects.grade());
  const auto limit = [](double& spread, double instability) {
    if (instability > 0) spread = std::min(spread, most * instability);
  };
  limit(spreads[0], unit.accel_noise.B), limit(spreads[1], unit.gyro_noise.B);
  const Conditions conditions = problem.conditions(spreads);
  const kernel::Parameters parameters = problem.parameters();
  return effects.p_value(parameters, adjust(conditions, parameters).solution, static_cast<int>(conditions.value.size()), 0, problem.indices());
}

/// Fits the determined coefficients, starting from a fit with all terms. Optional terms that the data do not determine return to zero, and the others
/// are fitted again with the same spreads. Other coefficients remain under their prior, determined or not: a weakly determined one does not bias
/// those that hardly depend on it. If a gyro scale has diverged, the whole gyro matrix returns to its prior, and rotations are not used because their
/// measured angles are wrong by the scales.
template <class Problem>
Fit fit_determined(Problem& problem, Fit fit) {
  if (const std::vector<Eigen::Index> matrix = problem.runaway_gyro_matrix(fit.parameters, fit.covariance()); !matrix.empty()) {
    problem.hold(matrix);
    problem.leave_out_rotations();
    fit = converge(problem);
  }
  const auto unseen = [&] { return problem.unseen_terms(fit.parameters, fit.covariance()); };
  for (std::vector<Eigen::Index> hold = unseen(); !hold.empty(); hold = unseen()) {
    problem.hold(hold);
    fit = converge(problem, fit.spreads);
  }
  fit.under_noise = adjust(problem.conditions({}), problem.parameters());
  fit.p_value = p_value(problem, fit.spreads);
  fit.excess = kernel::excess(fit.adjustment.solution.chi2, fit.adjustment.solution.degrees_of_freedom);
  return fit;
}

/// Predicts the fit before any data from a problem with ideal readings: the residuals are those of the noise.
template <class Problem>
Fit foreseen(Problem& problem) {
  Fit fit;
  for (std::vector<Eigen::Index> hold;; problem.hold(hold)) {
    fit.conditions = problem.conditions({});
    fit.parameters = problem.parameters();
    hold = problem.unseen_terms(fit.parameters, fit.covariance());
    if (hold.empty()) break;
  }
  fit.adjustment = fit.under_noise = adjust(fit.conditions, fit.parameters);
  fit.converged = true;
  return fit;
}

/// A rest or rotation that was left out.
struct DroppedPart {
  bool rotation;
  PartResidual residual;
};

/// A problem and its fit, for kernel::drop_suspects.
template <class Problem>
struct SuspectFit {
  Problem problem;
  Fit fit;
  std::size_t most;                    ///< number of suspects that may still be dropped
  std::shared_ptr<SuspectFit> next{};  ///< fit without the worst suspect
  std::vector<DroppedPart> dropped{};

  SuspectFit(const Problem& p, std::size_t m, const std::vector<DroppedPart>& d) : problem(p), most(m), dropped(d) {}  ///< not yet fitted
  explicit SuspectFit(Problem p) : problem(std::move(p)), fit(converge_with_sizes(problem)), most(problem.rests().size() / 3) {}

  /// The suspect whose removal saves the most chi-square per degree of freedom is tested against a fit without it: its own deviation would enlarge
  /// the spreads and hide it. The test includes the degrees of freedom of the spreads.
  std::vector<kernel::Suspect> suspects() {
    std::vector<kernel::Suspect> all;
    std::size_t worst = 0;
    double lowest = 0;
    for (const SuspectRows& suspect : problem.suspects(fit.conditions)) {
      const double p = deviation_of(fit.conditions, fit.adjustment, suspect.rows).log_probability();
      if (p < lowest) lowest = p, worst = all.size();
      all.push_back({suspect.name, 0});
    }
    if (lowest == 0 || most == 0) return all;
    next.reset();
    next = std::make_shared<SuspectFit>(problem, most - 1, dropped);
    next->problem.drop(worst);
    try {
      next->fit = converge(next->problem);
    } catch (const Unsupported&) {  // the other parts do not determine the suspect
      return all;
    }
    // With fewer remaining degrees of freedom, no part can be called an outlier.
    if (next->fit.adjustment.solution.degrees_of_freedom < 5) return all;
    const Conditions judged = problem.conditions(next->fit.spreads);
    const SuspectRows part = problem.suspects(judged)[worst];
    const kernel::Deviation deviation = deviation_of(judged, adjust(judged, problem.parameters()), part.rows);
    all[worst].log_probability = deviation.log_probability(next->fit.spread_degrees());
    const double residual = std::sqrt(deviation.chi2 / std::max(deviation.degrees_of_freedom, 1));
    next->dropped.push_back({part.rotation, {part.begin_s, part.end_s, residual, false}});
    return all;
  }
  bool may_drop(std::size_t) const { return true; }
  SuspectFit without(std::size_t) {
    SuspectFit out = std::move(*next);
    out.fit = converge_with_sizes(out.problem);
    return out;
  }
};

/// Converts a covariance of the scaled model's coefficients to raw readings and adds the uncertainty of g.
Eigen::MatrixXd raw_covariance(const RestProblem& problem, Eigen::MatrixXd covariance);

/// Returns model, covariance and quality of a fit in raw units, with the uncertainty of g and the names of undetermined coefficients.
Calibration calibration_of(std::string_view method, const RestProblem& problem, const Fit& fit, const Session& session);

/// Adds the residual of each rest and rotation; for omitted parts, their deviation from the others.
void add_parts(Quality& quality, const std::vector<SuspectRows>& parts, const Fit& fit, const std::vector<DroppedPart>& dropped);

/// Tests the coefficients of each optional term by Wald's test, without those that are not observable.
std::vector<TermTest> test_terms(const RestProblem& problem, const Fit& fit, double significance);

/// Adds the findings of a fit: widened priors, spreads, dropped parts of `all`, and causes of doubt.
void add_findings(kernel::Findings& findings, const Calibration& calibration, const RestProblem& problem, const Fit& fit, double curvature,
                  const Site& site, const std::vector<std::string>& dropped, std::size_t all);

}  // namespace imulab::rests
