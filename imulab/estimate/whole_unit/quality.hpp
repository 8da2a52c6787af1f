// The quality of a whole-unit calibration: residuals, coefficients that are not determined and why, estimated errors of the machines.
#pragma once

#include "imulab/estimate/kernel/findings.hpp"
#include "imulab/estimate/whole_unit/problem.hpp"
#include "imulab/model/calibration.hpp"

#include <vector>

namespace imulab::whole_unit {

/// The joint estimate of coefficients and errors of the machines, at the problem's model.
struct JointEstimate {
  kernel::Solution solution;  ///< covariance of theta and eta; chi2 against the noise as measured
  double condition = 0;
  double scatter = 1;  ///< by which the uncertainties are enlarged
  std::vector<TermTest> tests;
  kernel::Findings findings;
};

/// All but the findings of the estimate and the verdict.
Quality quality_of(const Problem& problem, const JointEstimate& estimate);

}  // namespace imulab::whole_unit
