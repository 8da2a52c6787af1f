// Fit iteration, and the calibration that a fit gives: to convergence, with the spread that the residuals show beyond the sample noise; without
// suspects that chance does not explain.
//
// A Problem is a RestProblem with conditions(spreads), parameters(), longest_step(), correct(correction), suspects(conditions) and drop(suspect).
#pragma once

#include "imulab/core/decomposition.hpp"
#include "imulab/core/error.hpp"
#include "imulab/estimate/kernel/suspects.hpp"
#include "imulab/estimate/rests/problem.hpp"

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
  double excess = 1;  ///< of the residuals over their size with the spreads, where chance does not explain it
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
/// large, with that kind's spread, until the spreads converge, or with the spreads that are `kept`. Longer steps than `longest_step` are shortened:
/// poor data would be linearized far from the solution.
template <class Problem>
Fit converge(Problem& problem, const std::optional<Spreads>& kept = {}) {
  constexpr int most_iterations = 30, most_before_spreads = 8;
  Fit fit;
  fit.spreads = kept.value_or(Spreads{});
  bool decided = kept.has_value();
  for (int iteration = 0; iteration < most_iterations && !fit.converged; ++iteration) {
    fit.conditions = problem.conditions(fit.spreads);
    fit.parameters = problem.parameters();
    fit.adjustment = adjust(fit.conditions, fit.parameters);
    const Eigen::VectorXd& x = fit.adjustment.solution.x;
    problem.correct(x / std::max(1.0, x.cwiseQuotient(problem.longest_step()).cwiseAbs().maxCoeff()));
    const Eigen::VectorXd sigma = fit.adjustment.solution.covariance.diagonal().cwiseSqrt();
    bool still = (sigma.array() > 0).select(x.cwiseAbs() - 0.01 * sigma, 0).maxCoeff() <= 0;  // fixed ones arrive at once
    if (!decided && !still && iteration < most_before_spreads) continue;
    for (int k = 0; k < kinds && !kept; ++k) {
      const auto kind = static_cast<Kind>(k);
      double& spread = fit.spreads[static_cast<std::size_t>(k)];
      if (spread == 0 && (decided || !spread_is_significant(fit.conditions, fit.adjustment, kind))) continue;
      const double before = std::exchange(spread, estimate_spread(fit.conditions, fit.adjustment, kind, spread));
      still = still && std::abs(spread - before) <= 0.02 * std::max(spread, before);
    }
    decided = true;
    fit.converged = still;
  }
  return fit;
}

/// How far the solution moves, in chi-square, where it is linearized one standard deviation away, along what the data say least of among the
/// matrices. Their products are linear in neither: with misalignments of 1e-3 open, combinations that are known to 1e-6 bend away.
template <class Problem>
double curvature(Problem problem, const Fit& fit) {
  const Eigen::MatrixXd& covariance = fit.adjustment.solution.covariance;
  Eigen::VectorXd away = weakest_matrix_direction(problem, covariance);
  problem.correct(away);
  away += adjust(problem.conditions(fit.spreads), problem.parameters()).solution.x;
  return squared_norm_in(covariance, away);
}
/// As much as one coefficient may be off: beyond it chi-square of all together is no longer what the covariance says.
inline constexpr double most_curvature = 1;

/// The same, with the priors of optional terms that the data contradict widened. Where the equations are not linear within the uncertainties, a
/// contradiction says nothing: what squares of the misalignments leave looks like such a term.
template <class Problem>
Fit converge_under_true_priors(Problem& problem) {
  constexpr int most_rounds = 10;
  Fit fit = converge(problem);
  for (int round = 0; round < most_rounds; ++round) {
    Problem wider = problem;
    if (!wider.widen_priors(fit.parameters, fit.adjustment.solution.covariance) || curvature(problem, fit) > most_curvature) break;
    problem = std::move(wider);
    fit = converge(problem);
  }
  return fit;
}

/// Optional terms of which the data say nothing go back to zero, and the others are fitted again. The spreads are those of the fit with all of them.
/// Other coefficients stay in the fit under their prior, determined or not: a weak one does not spoil those that it has little to do with. But a
/// gyro's scale that ran away goes back to its prior, with all of the matrix; then rotations say nothing, since what the gyros read in one is beside
/// the truth by their scales.
template <class Problem>
Fit fit_determined(Problem& problem) {
  Fit fit = converge(problem);
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
  fit.excess = kernel::excess(fit.adjustment.solution.chi2, fit.adjustment.solution.degrees_of_freedom);
  return fit;
}

/// The same before any data, at a problem of ideal readings: what the estimate will be where the residuals are the noise's.
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
  explicit SuspectFit(Problem p) : problem(std::move(p)), fit(converge_under_true_priors(problem)), most(problem.rests().size() / 3) {}

  /// The suspect whose loss would save the most chi-square for its degrees of freedom is judged by a fit without it: its own deviation would hide it
  /// in the spreads, which count with the degrees of freedom behind them.
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
    } catch (const Unsupported&) {  // the others say nothing of it
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
  SuspectFit without(std::size_t) { return std::move(*next); }
};

/// A covariance of the scaled model's coefficients as that of raw readings, with g's uncertainty.
Eigen::MatrixXd raw_covariance(const RestProblem& problem, Eigen::MatrixXd covariance);

/// Model, covariance and quality of a fit: raw units, g's uncertainty added, undetermined coefficients named.
Calibration calibration_of(std::string_view method, const RestProblem& problem, const Fit& fit, const Session& session);

/// How each rest and each rotation agrees with the fit; those left out by what they deviate from the others.
void add_parts(Quality& quality, const std::vector<SuspectRows>& parts, const Fit& fit, const std::vector<DroppedPart>& dropped);

/// Which optional terms do the data show? Wald's test of each term's coefficients, without those of which the data say nothing.
std::vector<TermTest> test_terms(const RestProblem& problem, const Fit& fit, double significance);

/// The findings of a fit: widened priors, spreads, dropped parts of `all`, and what makes it doubtful.
void add_findings(kernel::Findings& findings, const Calibration& calibration, const RestProblem& problem, const Fit& fit, double curvature,
                  const Site& site, const std::vector<std::string>& dropped, std::size_t all);

}  // namespace imulab::rests
