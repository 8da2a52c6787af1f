// Explanations of readings beyond effects and terms of the inferred sizes: one bad step, a unit that moved in its mount, or noise and a table that
// are worse than declared.
#pragma once

#include "imulab/estimate/turntable/fit.hpp"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace imulab::turntable {

struct Explained {
  Fit fit;
  std::vector<std::string> dropped;  ///< steps that were left out
  std::string worst;                 ///< step with the largest deviation, if noise and table explain more
  bool by_size = false;              ///< noise or table are worse than declared
};

/// Returns the joint covariance of the coefficients, whose covariance is given, and the effects.
Eigen::MatrixXd joint_covariance(const Fit& fit, const std::vector<CoefficientIndex>& coefficients, const Eigen::MatrixXd& covariance);

/// Returns the fit with inferred sizes of effects and optional terms (kernel::Effects::infer).
Fit with_inferred_sizes(Fit fit);
/// Returns the p-value of kernel::Effects::p_value.
double p_value(const Fit& fit);

/// Applies explanations one by one, the most probable first: by the log ratio of the readings' probabilities with and without it, for noise and table
/// at the most likely size of their errors. `level`: of outliers, for all steps together.
Explained explained(const Fit& fit, const kernel::EffectSizes& sizes, double level);

}  // namespace imulab::turntable
