// The course of a fit: iterate to convergence, let the residuals say how much more than the sample noise they spread, drop what is off.
//
// A Problem has conditions(spreads), prior_sigma(), correct(correction), suspects(conditions) and drop(index).
#pragma once

#include "imulab/estimate/adjustment.hpp"

#include <algorithm>
#include <cmath>
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

/// Gauss-Newton until the correction is below a hundredth of its standard deviation everywhere, and the spreads stand still. What is found
/// undetermined on the way returns to its starting value and stays there: a parameter that the data hold only now and then would run away.
template <class Problem>
Fit converge(Problem& problem, const Spreads& start = {}, int most_iterations = 20) {
  Fit fit;
  fit.spreads = start;
  Eigen::VectorXd moved;  // of each parameter since the start
  std::vector<char> excluded;
  for (int iteration = 0; iteration < most_iterations && !fit.converged; ++iteration) {
    fit.conditions = problem.conditions(fit.spreads);
    fit.adjustment = adjust(fit.conditions, problem.prior_sigma(), excluded);
    Eigen::VectorXd correction = fit.adjustment.correction;
    if (iteration == 0) {
      moved.setZero(correction.size());
      excluded.resize(static_cast<std::size_t>(correction.size()), 0);
    }
    bool returned = false;
    for (std::size_t i = 0; i < excluded.size(); ++i) {
      if (fit.adjustment.determined[i]) continue;
      const auto at = static_cast<Eigen::Index>(i);
      returned = returned || moved[at] != 0;
      correction[at] = -moved[at];
      excluded[i] = 1;
    }
    moved += correction;
    problem.correct(correction);
    const Eigen::VectorXd sigma = fit.adjustment.covariance.diagonal().cwiseSqrt();
    fit.converged = !returned && (fit.adjustment.correction.cwiseAbs() - 0.01 * sigma).maxCoeff() <= 0;
    for (int k = 0; k < spread_kinds; ++k) {
      double& spread = fit.spreads[static_cast<std::size_t>(k)];
      const double before = std::exchange(spread, estimate_spread(fit.conditions, fit.adjustment, static_cast<ConditionKind>(k), spread));
      fit.converged = fit.converged && std::abs(spread - before) <= 0.02 * std::max(spread, before);
    }
  }
  return fit;
}

/// The least probable suspect and the logarithm of its probability.
struct Worst {
  int index = -1;
  double log_probability = 0;
};

template <class Problem>
Worst worst_suspect(const Problem& problem, const Conditions& conditions, const Adjustment& adjustment) {
  const std::vector<Suspect> suspects = problem.suspects(conditions);
  Worst worst;
  for (std::size_t i = 0; i < suspects.size(); ++i) {
    const double p = outlier_log_probability(conditions, adjustment, suspects[i].rows);
    if (p < worst.log_probability) worst = {static_cast<int>(i), p};
  }
  return worst;
}

/// Drops suspects one by one, the least probable first, while chance explains it with less than `level` shared among all (Bonferroni). The spreads are
/// those of the data without the suspect, which would otherwise hide itself. Returns the names of what was dropped.
template <class Problem>
std::vector<std::string> drop_outliers(Problem& problem, double level) {
  std::vector<std::string> dropped;
  Fit fit = converge(problem);
  for (std::size_t most = problem.rests().size() / 3; dropped.size() < most;) {
    const Worst candidate = worst_suspect(problem, fit.conditions, fit.adjustment);
    if (candidate.index < 0) break;
    Problem without = problem;
    without.drop(candidate.index);
    const Fit fit_without = converge(without, fit.spreads);
    const Conditions judged = problem.conditions(fit_without.spreads);
    const Suspect suspect = problem.suspects(judged)[static_cast<std::size_t>(candidate.index)];
    const double log_p = outlier_log_probability(judged, adjust(judged, problem.prior_sigma()), suspect.rows);
    if (log_p > std::log(level / static_cast<double>(problem.suspects(judged).size()))) break;
    dropped.push_back(suspect.name);
    problem = without;
    fit = fit_without;
  }
  return dropped;
}

}  // namespace imulab
