// The quality of a whole-unit calibration: residuals, undetermined coefficients with reasons, and estimated errors of the machines. Also faults of
// sessions that could be calibrated: machines that are not as declared, chamber points that had not settled, and hysteresis.
#pragma once

#include "imulab/estimate/kernel/findings.hpp"
#include "imulab/estimate/whole_unit/problem.hpp"

#include <string>
#include <vector>

namespace imulab::whole_unit {

/// The joint estimate of coefficients and machine errors. The values are in the model and common errors of the problem.
struct JointEstimate {
  kernel::Solution solution;  ///< covariance of theta and eta; chi2 relative to the measured noise
  double condition = 0;
  double scatter = 1;  ///< factor that enlarges the uncertainties
  bool converged = false;
  std::vector<TermTest> tests;
  std::vector<std::size_t> left_out;  ///< coefficients of terms that are not significant: zero, but their uncertainty counts
  kernel::Findings findings;
};

/// Returns the quality without the findings of the estimate and the verdict.
Quality quality_of(const PointProblem& problem, const JointEstimate& estimate);

/// Returns the single machine error that explains most of the points' excess scatter, with its consequence; empty if there is none.
kernel::Findings wrong_machine(const PointProblem& problem);

/// Warns of chamber points that had not settled, and of hysteresis.
void check_chamber(kernel::Findings& findings, const PointProblem& problem);

}  // namespace imulab::whole_unit
