// The problem. Nothing but gravity and the Earth's rate is known of a unit that was turned by hand, so there are no readings with known inputs. There
// are conditions F(x, v) = 0 between the coefficients x and the mean readings v of rests, as |A1 v + A0| = g. A condition errs by the noise of its
// readings, times its derivative by them, which depends on x. Two things are not known besides x: whether the noise of a mean is only that of its
// samples (a hand trembles, an offset wanders from rest to rest), and which rests are bad.
//
// A small case. One axis points up, down and up again, and its means are v1 = 9.910, v2 = -9.710 and v3 = 9.930 m/s^2, each with a standard deviation
// of 0.001 by the samples' noise, g = 9.810. The conditions are
//
//     k v1 + b - g = 0,   -(k v2 + b) - g = 0,   k v3 + b - g = 0.
//
// Least squares gives k = 2g / (9.920 + 9.710) = 0.99949 and b = -0.105. The second condition holds, the others miss by -0.010 and +0.010. With one
// degree of freedom chi-square is 2 (0.010 / 0.001)^2 = 200: chance does not explain that. Either the means spread by more than the samples' noise,
// by about 0.014, and b is uncertain by 0.009 instead of 0.0006. Or one rest is bad; but three rests cannot tell which. With twenty rests they can: a
// bad rest stands alone, a spread is in all.
//
// So a fit has three loops, one in the other:
// - `converge`: Gauss-Newton steps under the present spreads; then the spread of each kind of condition is estimated until both stand still.
// - `converge_with_sizes`: effects and optional terms get priors of the size that the data infer.
// - SuspectFit: the worst suspect is judged by the fit without it, since with it the spread would grow until the suspect fits; what it deviates is
//   compared with a spread of few degrees of freedom (F distribution), and shared among all suspects.
// `fit_determined` last leaves the optional terms that the data do not show at zero, considered.
//
// A Problem is a RestProblem with conditions(spreads), parameters(), longest_step(), correct(correction), suspects(conditions) and drop(suspect).
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
  Adjustment under_noise{};  ///< by the sample noise alone, of what `fit_determined` arrives at
  Spreads spreads{};
  double p_value = 1;  ///< as Effects::p_value
  double excess = 1;   ///< of the residuals over their size with the spreads, where chance does not explain it
  bool converged = false;

  /// With the effect of the considered parameters on the others.
  Eigen::MatrixXd covariance() const { return kernel::solve(conditions.information(), parameters, "the rests").covariance; }
  /// Degrees of freedom behind the least known of the spreads in use; infinite where none is.
  double spread_degrees() const {
    double degrees = std::numeric_limits<double>::infinity();
    for (int k = 0; k < kinds; ++k)
      if (spreads[static_cast<std::size_t>(k)] > 0) degrees = std::min(degrees, redundancy(conditions, adjustment, static_cast<Kind>(k)));
    return degrees;
  }
};

/// One standard deviation along the least known combination of the matrices' elements, which the other parameters follow.
Eigen::VectorXd weakest_matrix_direction(const RestProblem& problem, const Eigen::MatrixXd& covariance);

/// Gauss-Newton until the correction is below a hundredth of its standard deviation everywhere; then, where residuals of a kind are significantly too
/// large, with that kind's spread, until the spreads converge, or with the spreads that are `kept`. Steps longer than `longest_step` are shortened:
/// poor data would be linearized far from the solution.
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

/// The change of the solution, in chi-square, when it is linearized one standard deviation away along the least determined combination of the
/// matrices. Their products are linear in neither: where misalignments of 1e-3 are not determined, combinations known to 1e-6 bend away.
template <class Problem>
double curvature(Problem problem, const Fit& fit) {
  const Eigen::MatrixXd& covariance = fit.adjustment.solution.covariance;
  Eigen::VectorXd away = weakest_matrix_direction(problem, covariance);
  problem.correct(away);
  away += adjust(problem.conditions(fit.spreads), problem.parameters()).solution.x;
  return squared_norm_in(covariance, away);
}
/// The deviation that one coefficient may have: beyond it, chi-square of all together no longer agrees with the covariance.
inline constexpr double most_curvature = 1;

/// Infers the sizes of effects and optional terms from a fit, and fits again. Without effects terms have their expected sizes, unless the data
/// contradict one; where the equations are not linear within the uncertainties that means nothing, since second-order misalignment residuals mimic
/// terms.
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

/// Logarithm of the data's probability, whatever coefficients, effects, and the effects' sizes are within their priors.
template <class Problem>
double log_probability(Problem& problem, const Fit& fit) {
  const Conditions conditions = problem.conditions(fit.spreads);
  return kernel::log_probability(conditions.information(), problem.parameters(), "the rests") - 0.5 * conditions.log_determinant() +
         problem.effects().log_gain();
}

/// Residuals that are larger than the noise may be effects or spreads, each of which hides the other: of both starts the more probable end counts.
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

/// The predictive test. Offsets may scatter from rest to rest by four times the bias instability of the grade, turns by what a hand does.
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

/// From a fit with all terms. Optional terms that the data do not show go back to zero, and the others are fitted again. The spreads are those of the
/// fit with all terms. Other coefficients stay in the fit under their prior, determined or not: a weakly determined one does not bias those that
/// hardly depend on it. But a gyro's scale that diverged goes back to its prior, with all of the matrix; then rotations carry no information, since
/// the angle that the gyros measure in one is wrong by their scales.
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

/// Foresees the fit before any data, at a problem of ideal readings: the estimate where the residuals are those of the noise.
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

/// A rest or a rotation that is left out.
struct DroppedPart {
  bool rotation;
  PartResidual residual;
};

/// A problem and its fit, for kernel::drop_suspects.
template <class Problem>
struct SuspectFit {
  Problem problem;
  Fit fit;
  std::size_t most;                    ///< that may still be dropped
  std::shared_ptr<SuspectFit> next{};  ///< without the worst suspect
  std::vector<DroppedPart> dropped{};

  SuspectFit(const Problem& p, std::size_t m, const std::vector<DroppedPart>& d) : problem(p), most(m), dropped(d) {}  ///< not yet fitted
  explicit SuspectFit(Problem p) : problem(std::move(p)), fit(converge_with_sizes(problem)), most(problem.rests().size() / 3) {}

  /// The suspect whose removal would save the most chi-square for its degrees of freedom is judged by a fit without it: its own deviation would hide
  /// it in the spreads, which count with the degrees of freedom behind them.
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
    } catch (const Unsupported&) {  // the others do not determine it
      return all;
    }
    // With fewer degrees of freedom left nothing can be called an outlier.
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

/// A covariance of the scaled model's coefficients as that of raw readings, with g's uncertainty.
Eigen::MatrixXd raw_covariance(const RestProblem& problem, Eigen::MatrixXd covariance);

/// Model, covariance and quality of a fit: raw units, g's uncertainty added, undetermined coefficients named.
Calibration calibration_of(std::string_view method, const RestProblem& problem, const Fit& fit, const Session& session);

/// Adds the residual of each rest and each rotation; of those left out, the deviation from the others.
void add_parts(Quality& quality, const std::vector<SuspectRows>& parts, const Fit& fit, const std::vector<DroppedPart>& dropped);

/// Wald's test of each optional term's coefficients, without those that the data do not show.
std::vector<TermTest> test_terms(const RestProblem& problem, const Fit& fit, double significance);

/// The findings of a fit: widened priors, spreads, dropped parts of `all`, and what makes it doubtful.
void add_findings(kernel::Findings& findings, const Calibration& calibration, const RestProblem& problem, const Fit& fit, double curvature,
                  const Site& site, const std::vector<std::string>& dropped, std::size_t all);

}  // namespace imulab::rests
