// The fleet's prediction of its next unit before it is measured, and a calibration combined with this prior (docs/start/fleet.md).
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/eigen.hpp"
#include "imulab/fleet.hpp"
#include "imulab/session.hpp"

#include <functional>
#include <string>
#include <vector>

namespace imulab {

/// The predictive distribution of one unit more, of offsets and matrices: the mean of the fleet's units without its outliers, and the covariance of
/// their last calibrations (as they scatter, so that the uncertainty of measurement widens it) times (1 + 1/n)(n - 1)/(n - p - 2), which n units of
/// p coefficients leave open (Student's distribution with n - p degrees of freedom has that variance). Optional terms are not in it: each
/// calibration has their prior already. Of terms over temperature it has the sizes, by which a method replaces that prior. `covariance`: as
/// fleet_statistics takes it. Throws Error for fewer than p + 6 units, and where most have none of these coefficients in common.
FleetPrior fleet_prior(const FleetSample& sample, const std::function<Eigen::MatrixXd(Eigen::Index row)>& covariance);

/// Tests the terms over temperature of a calibration without prior against the fleet's sizes. `taken`: it has such terms, and they are plausible.
PriorUse fit_of_sizes(const Calibration& calibration, const FleetPrior& prior);
/// The session of a unit of this fleet: where it declares no sizes of terms over temperature, and reads degC or K, it has the fleet's.
Session with_sizes(Session session, const FleetPrior& prior);

/// The limits that a session has to reach so that session and prior together meet these requirements: 1/limit^2 = 1/session^2 + 1/prior^2, each
/// coefficient by itself (the correlations of the prior only help). Those that the prior alone meets are not among them.
std::vector<Requirement> left_to_reach(const std::vector<Requirement>& requirements, const FleetPrior& prior);
/// Prior sigma of a coefficient, of matrices relative to the row's scale; infinite where there is none.
double relative_sigma(const FleetPrior& prior, CoefficientIndex index);

}  // namespace imulab
