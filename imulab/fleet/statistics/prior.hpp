// The fleet's prediction of its next unit before it is measured, and a calibration combined with this prior (docs/fleet.md).
#pragma once

#include "imulab/core/eigen.hpp"
#include "imulab/fleet/statistics/sample.hpp"
#include "imulab/model/calibration.hpp"
#include "imulab/model/requirement.hpp"

#include <functional>
#include <string>
#include <vector>

namespace imulab {

/// In the accelerometers' frame, SI.
struct FleetPrior {
  std::string fleet;  ///< where it is from, as a note names it: "fleet.db"
  double units = 0;   ///< that it rests on: without outliers
  std::string accel_unit, gyro_unit;
  std::vector<CoefficientIndex> coefficients;
  Eigen::VectorXd mean;
  Eigen::MatrixXd covariance;  ///< of a unit that was not measured yet
};

/// The predictive distribution of one unit more, of offsets and matrices: the mean of the fleet's units without its outliers, and the covariance of
/// their last calibrations (as they scatter, so that the uncertainty of measurement widens it) times (1 + 1/n)(n - 1)/(n - p - 2), which n units of
/// p coefficients leave open (Student's distribution with n - p degrees of freedom has that variance). Optional terms are not in it: each
/// calibration has their prior already. `covariance`: as fleet_statistics takes it. Throws Error for fewer than p + 6 units, and where
/// most have none of these coefficients in common.
FleetPrior fleet_prior(const FleetSample& sample, const std::function<Eigen::MatrixXd(Eigen::Index row)>& covariance);

/// The use of a prior in a calibration.
struct PriorUse {
  bool taken = false;                    ///< false: the unit contradicts the fleet, and its calibration stays as it is
  double distance = 0;                   ///< of the calibration from the fleet's mean: Mahalanobis
  double p_value = 1;                    ///< of so large a distance of a unit of this fleet
  std::vector<CoefficientIndex> filled;  ///< coefficients that the data did not determine: they have the values that the fleet predicts
};

/// The calibration in the accelerometers' frame, with the prior as one observation more. A coefficient that it leaves open has afterwards what the
/// prior says of it, given the others; these do not become more certain by that. A calibration that chance puts so far from the fleet less than once
/// in a thousand does not take the prior. Throws Error where the readings' units are others than the fleet's,
/// and where the calibration and the fleet have nothing in common.
PriorUse take_prior(Calibration& calibration, const FleetPrior& prior);

/// The limits that a session has to reach so that session and prior together meet these requirements: 1/limit^2 = 1/session^2 + 1/prior^2, each
/// coefficient by itself (the correlations of the prior only help). Those that the prior alone meets are not among them.
std::vector<Requirement> left_to_reach(const std::vector<Requirement>& requirements, const FleetPrior& prior);
/// Prior sigma of a coefficient, of matrices relative to the row's scale; infinite where there is none.
double relative_sigma(const FleetPrior& prior, CoefficientIndex index);

}  // namespace imulab
