// Units that do not belong to the fleet: their distance from its mean, against their own uncertainty and the spread between units.
#pragma once

#include "imulab/eigen.hpp"
#include "imulab/fleet.hpp"

#include <functional>
#include <vector>

namespace imulab {

/// The units' data: rows of values are units, columns coefficients; NaN where a unit has none.
struct OutlierInput {
  Eigen::MatrixXd values;
  Eigen::MatrixXd mean_covariance;                               ///< of the measurement, over the units
  std::function<Eigen::MatrixXd(Eigen::Index unit)> covariance;  ///< of one unit's measurement, of all columns; called where it matters
};

/// Each unit is tested at false_alarm / units (Bonferroni). Mean and spread are those of the units that are none: which these are is repeated until
/// nothing changes, from the medians on; a unit is judged by the others. Distances follow Hotelling's T^2 distribution, exactly so where all units
/// are measured equally well.
OutlierSearch find_outliers(const OutlierInput& input, double false_alarm = 0.01);

}  // namespace imulab
