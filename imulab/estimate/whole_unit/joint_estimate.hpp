// The joint estimate of coefficients and errors of the machines: determined coefficients, significant terms, outliers, noise.
#pragma once

#include "imulab/estimate/kernel/findings.hpp"
#include "imulab/estimate/method.hpp"
#include "imulab/estimate/whole_unit/problem.hpp"

#include <vector>

namespace imulab::whole_unit {

/// The estimate itself is the problem's model and common errors.
struct JointEstimate {
  kernel::Solution solution;  ///< covariance of theta and eta; chi2 against the noise as measured
  double condition = 0;
  double scatter = 1;  ///< by which the uncertainties are enlarged
  bool converged = false;
  std::vector<TermTest> tests;
  std::vector<std::size_t> left_out;  ///< coefficients of terms that are not significant: zero, but their uncertainty counts
  kernel::Findings findings;
};

/// Coefficients that the data do not determine become considered. Outliers are dropped point by point while chance explains them with less than
/// `outlier_level` shared among all; where those are more than one in fifty they are no outliers, and all stay. An optional term (cubic, quadratic,
/// second-order thermal, g-sensitivity, by triad) is fixed at its starting value if it is not significant and points left out (ten parts) are not
/// predicted worse without it beyond chance.
JointEstimate joint_estimate(Problem& problem, const CalibrationOptions& options);

}  // namespace imulab::whole_unit
