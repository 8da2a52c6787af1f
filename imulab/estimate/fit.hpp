// The course of a fit: iterate to convergence, let the residuals say how much more than the sample noise they spread, drop what is off.
//
// A Problem has conditions(spreads), prior_sigma(), correct(correction), suspects(conditions) and drop(index).
#pragma once

#include "imulab/estimate/adjustment.hpp"

#include <string>

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

enum class SpreadMode { keep, robust, mean };

/// Gauss-Newton until the correction is below a hundredth of its standard deviation everywhere.
template <class Problem>
Fit converge(Problem& problem, Spreads spreads, SpreadMode mode, int most_iterations = 20) {
  Fit fit;
  fit.spreads = spreads;
  for (int iteration = 0; iteration < most_iterations && !fit.converged; ++iteration) {
    fit.conditions = problem.conditions(fit.spreads);
    fit.adjustment = adjust(fit.conditions, problem.prior_sigma());
    problem.correct(fit.adjustment.correction);
    const Eigen::VectorXd sigma = fit.adjustment.covariance.diagonal().cwiseSqrt();
    bool still = true;
    for (Eigen::Index i = 0; i < sigma.size(); ++i) still = still && std::abs(fit.adjustment.correction[i]) <= 0.01 * sigma[i];
    if (mode != SpreadMode::keep) {
      for (int k = 0; k < spread_kinds; ++k) {
        const double before = fit.spreads[static_cast<std::size_t>(k)];
        const double now = estimate_spread(fit.conditions, fit.adjustment, static_cast<ConditionKind>(k), before, mode == SpreadMode::robust);
        fit.spreads[static_cast<std::size_t>(k)] = now;
        still = still && std::abs(now - before) <= 0.02 * std::max(now, before);
      }
    }
    fit.converged = still;
  }
  return fit;
}

/// The most improbable suspect below `level` shared among all (Bonferroni), or -1.
template <class Problem>
int worst_suspect(const Problem& problem, const Fit& fit, double level) {
  const std::vector<Suspect> suspects = problem.suspects(fit.conditions);
  int worst = -1;
  double lowest = std::log(level / static_cast<double>(std::max<std::size_t>(suspects.size(), 1)));
  for (std::size_t i = 0; i < suspects.size(); ++i) {
    const double p = outlier_log_probability(fit.conditions, fit.adjustment, suspects[i].rows);
    if (p < lowest) {
      lowest = p;
      worst = static_cast<int>(i);
    }
  }
  return worst;
}

}  // namespace imulab
