// The quality of a whole-unit calibration: residuals, coefficients that are not determined and why, estimated errors of the machines. And faults of a
// session that could be calibrated: machines that are not as declared, a chamber whose points had not settled, hysteresis.
#pragma once

#include "imulab/estimate/kernel/findings.hpp"
#include "imulab/estimate/whole_unit/problem.hpp"

#include <string>
#include <vector>

namespace imulab::whole_unit {

/// The joint estimate of coefficients and machine errors. The estimate itself is the problem's model and common errors.
struct JointEstimate {
  kernel::Solution solution;  ///< covariance of theta and eta; chi2 against the noise as measured
  double condition = 0;
  double scatter = 1;  ///< by which the uncertainties are enlarged
  bool converged = false;
  std::vector<TermTest> tests;
  std::vector<std::size_t> left_out;  ///< coefficients of terms that are not significant: zero, but their uncertainty counts
  kernel::Findings findings;
};

/// All but the findings of the estimate and the verdict.
Quality quality_of(const PointProblem& problem, const JointEstimate& estimate);

/// The one error of a machine that explains most of the points' excess scatter, with its consequence; empty where there is none.
kernel::Findings wrong_machine(const PointProblem& problem);

/// Warns of chamber points that had not settled, and of hysteresis.
void check_chamber(kernel::Findings& findings, const PointProblem& problem);

}  // namespace imulab::whole_unit
