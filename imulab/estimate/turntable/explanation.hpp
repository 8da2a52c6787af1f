// What explains readings beside effects and terms of the sizes that they show: one bad step, a unit that moved in its mount, or noise and a table
// that are worse than declared.
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
  std::string worst;                 ///< the step that deviates most, where noise and table explain more than it does
  bool by_size = false;              ///< noise or table are worse than declared
};

/// Of coefficients, whose covariance is given, and then the effects.
Eigen::MatrixXd joint_covariance(const Fit& fit, const std::vector<CoefficientIndex>& coefficients, const Eigen::MatrixXd& covariance);

/// The fit with sizes of effects and optional terms that the readings show, as kernel::Effects::infer.
Fit with_inferred_sizes(Fit fit);
/// As kernel::Effects::p_value.
double p_value(const Fit& fit);

/// Takes the explanations one by one, that first for which most speaks: the logarithm of the ratio of the readings' probabilities with it and without
/// it, which for the noise and the table is that of the most likely size of their errors. `level`: of outliers, shared among the steps.
Explained explained(const Fit& fit, const kernel::EffectSizes& sizes, double level);

}  // namespace imulab::turntable
