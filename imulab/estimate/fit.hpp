// The course of a fit: iterate to convergence, let the residuals say how much more than the sample noise they spread, drop what is off.
//
// A Problem has rests(), indices(), conditions(spreads), prior_sigma(), correct(correction), needed_sigma(), pin(determined), suspects(conditions) and drop(index).
#pragma once

#include "imulab/estimate/adjustment.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace imulab {

struct Fit {
  Conditions conditions;
  Adjustment adjustment;
  Spreads spreads{};
  bool converged = false;
};

/// Something that may be bad as a whole: a rest, a rotation.
struct Suspect {
  std::string name;
  std::vector<Eigen::Index> rows;
};

/// Gauss-Newton until the correction is below a hundredth of its standard deviation everywhere; then, where residuals of a kind are significantly too large
/// (or its spread was given), with that kind's spread, until the spreads stand still. No step goes beyond `longest_step`, by default one prior sigma:
/// poor data would be linearised far from where the answer is.
template <class Problem>
Fit converge(Problem& problem, const Spreads& start, const Eigen::VectorXd& longest_step) {
  constexpr int most_iterations = 30, most_before_spreads = 8;
  Fit fit;
  fit.spreads = start;
  bool decided = false;
  for (int iteration = 0; iteration < most_iterations && !fit.converged; ++iteration) {
    fit.conditions = problem.conditions(fit.spreads);
    fit.adjustment = adjust(fit.conditions, problem.prior_sigma());
    const double steps = fit.adjustment.correction.cwiseQuotient(longest_step).cwiseAbs().maxCoeff();
    problem.correct(fit.adjustment.correction / std::max(1.0, steps));
    const Eigen::VectorXd sigma = fit.adjustment.covariance.diagonal().cwiseSqrt();
    bool still = (fit.adjustment.correction.cwiseAbs() - 0.01 * sigma).maxCoeff() <= 0;
    if (!decided && !still && iteration < most_before_spreads) continue;
    for (int k = 0; k < spread_kinds; ++k) {
      const auto kind = static_cast<ConditionKind>(k);
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
template <class Problem>
Fit converge(Problem& problem) {
  return converge(problem, {}, problem.prior_sigma());
}

/// converge, then what is undetermined returns to its starting value and the rest settles around it, until what remains is determined though the held
/// ones may be off by their prior.
template <class Problem>
Fit settle(Problem& problem) {
  Fit fit = converge(problem);
  const Eigen::VectorXd needed = problem.needed_sigma(), prior_sigma = problem.prior_sigma();
  std::vector<char> determined(static_cast<std::size_t>(prior_sigma.size()), 1);
  for (bool changed = true; changed;) {
    changed = false;
    for (Eigen::Index i = 0; i < needed.size(); ++i) {
      char& known = determined[static_cast<std::size_t>(i)];
      if (!known || fit.adjustment.covariance(i, i) < needed[i] * needed[i]) continue;
      known = 0;
      changed = true;
    }
    if (!changed) break;
    problem.pin(determined);
    fit = converge(problem, fit.spreads, prior_sigma);
    fit.adjustment.covariance = covariance_considering(problem.conditions(fit.spreads), prior_sigma, determined);
  }
  fit.adjustment.determined = determined;
  return fit;
}

/// The suspect whose loss would save the most chi-square for its degrees of freedom; -1 for none.
template <class Problem>
int worst_suspect(const Problem& problem, const Fit& fit) {
  const std::vector<Suspect> suspects = problem.suspects(fit.conditions);
  int worst = -1;
  double lowest = 0;
  for (std::size_t i = 0; i < suspects.size(); ++i) {
    const double p = deviation_of(fit.conditions, fit.adjustment, suspects[i].rows).log_probability();
    if (p < lowest) {
      lowest = p;
      worst = static_cast<int>(i);
    }
  }
  return worst;
}

/// Degrees of freedom behind the least known of the spreads in use; infinite where none is.
inline double spread_degrees(const Fit& fit) {
  double degrees = std::numeric_limits<double>::infinity();
  for (int k = 0; k < spread_kinds; ++k)
    if (fit.spreads[static_cast<std::size_t>(k)] > 0) degrees = std::min(degrees, redundancy(fit.conditions, fit.adjustment, static_cast<ConditionKind>(k)));
  return degrees;
}

/// Drops suspects one by one, the least probable first, while chance explains it with less than `level` shared among all (Bonferroni). The spreads are
/// those of the data without the suspect, which would otherwise hide itself, and count with the degrees of freedom they rest on. Returns the names of
/// what was dropped.
template <class Problem>
std::vector<std::string> drop_outliers(Problem& problem, double level) {
  std::vector<std::string> dropped;
  Fit fit = converge(problem);
  for (std::size_t most = problem.rests().size() / 3; dropped.size() < most;) {
    const int candidate = worst_suspect(problem, fit);
    if (candidate < 0) break;
    Problem without = problem;
    without.drop(candidate);
    const Fit fit_without = converge(without);
    // With fewer degrees of freedom left nothing can be called an outlier.
    if (fit_without.adjustment.degrees_of_freedom < 5) break;
    const Conditions judged = problem.conditions(fit_without.spreads);
    const Suspect suspect = problem.suspects(judged)[static_cast<std::size_t>(candidate)];
    const Deviation deviation = deviation_of(judged, adjust(judged, problem.prior_sigma()), suspect.rows);
    const double degrees = spread_degrees(fit_without);
    const double log_p = std::isinf(degrees) ? deviation.log_probability() : deviation.log_probability(degrees);
    if (log_p > std::log(level / static_cast<double>(problem.suspects(judged).size()))) break;
    dropped.push_back(suspect.name);
    problem = without;
    fit = fit_without;
  }
  return dropped;
}

}  // namespace imulab
