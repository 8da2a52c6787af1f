// Dai's three steps one after the other (Dai 2011 section 3.1), each by unweighted least squares, with the covariance that noise and the machines'
// errors give the whole chain.
#pragma once

#include "imulab/estimate/whole_unit/problem.hpp"

namespace imulab::whole_unit {

struct StepwiseEstimate {
  SensorModel model;           ///< of readings less the problem's center
  Eigen::MatrixXd covariance;  ///< of the problem's coefficients; zero where it was not asked for
};

/// Needs a chamber, a rate table with opposed mounts along every axis, and a centrifuge with an accelerometer of each axis outward: throws
/// Unsupported that says so, or which points do not determine their coefficients.
StepwiseEstimate stepwise_estimate(const Problem& problem, bool with_covariance);

}  // namespace imulab::whole_unit
