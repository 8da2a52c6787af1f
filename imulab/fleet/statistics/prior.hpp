// The fleet's prediction of its next unit before it is measured, and a calibration combined with this prior (docs/start/fleet.md).
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/eigen.hpp"
#include "imulab/fleet.hpp"

#include <functional>
#include <string>
#include <vector>

namespace imulab {

/// The predictive distribution of one unit more, of offsets and matrices: the mean of the fleet's units without its outliers, and the covariance of
/// their last calibrations (as they scatter, so that the uncertainty of measurement widens it) times (1 + 1/n)(n - 1)/(n - p - 2), which n units of
/// p coefficients leave open (Student's distribution with n - p degrees of freedom has that variance). Optional terms are not in it: each
/// calibration has their prior already. `covariance`: as fleet_statistics takes it. Throws Error for fewer than p + 6 units, and where
/// most have none of these coefficients in common.
FleetPrior fleet_prior(const FleetSample& sample, const std::function<Eigen::MatrixXd(Eigen::Index row)>& covariance);

/// The limits that a session has to reach so that session and prior together meet these requirements: 1/limit^2 = 1/session^2 + 1/prior^2, each
/// coefficient by itself (the correlations of the prior only help). Those that the prior alone meets are not among them.
std::vector<Requirement> left_to_reach(const std::vector<Requirement>& requirements, const FleetPrior& prior);
/// Prior sigma of a coefficient, of matrices relative to the row's scale; infinite where there is none.
double relative_sigma(const FleetPrior& prior, CoefficientIndex index);

}  // namespace imulab
