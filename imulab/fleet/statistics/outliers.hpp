// Units that do not belong to the fleet: their distance from its mean, against their own uncertainty and the spread between units.
#pragma once

#include "imulab/core/eigen.hpp"

#include <functional>
#include <vector>

namespace imulab {

/// The units' data: rows of values are units, columns coefficients; NaN where a unit has none.
struct OutlierInput {
  Eigen::MatrixXd values;
  Eigen::MatrixXd mean_covariance;                               ///< of the measurement, over the units
  std::function<Eigen::MatrixXd(Eigen::Index unit)> covariance;  ///< of one unit's measurement, of all columns; called where it matters
};

struct FleetOutlier {
  Eigen::Index unit = 0;
  double distance = 0;     ///< Mahalanobis, not squared
  int coefficients = 0;    ///< that it has
  double p_value = 1;      ///< of so large a distance of one unit that belongs to the fleet
  Eigen::Index worst = 0;  ///< the column that is farthest from the mean by itself
  double worst_sigmas = 0;
};

struct OutlierSearch {
  bool possible = false;   ///< false: there are too few units for so many coefficients
  double false_alarm = 0;  ///< probability of any outlier in a fleet without
  Eigen::VectorXd mean;
  Eigen::MatrixXd spread;              ///< covariance between units, apart from the measurement
  std::vector<FleetOutlier> outliers;  ///< the farthest first
};

/// Each unit is tested at false_alarm / units (Bonferroni). Mean and spread are those of the units that are none: which these are is repeated until
/// nothing changes, from the medians on; a unit is judged by the others. Distances follow Hotelling's T^2 distribution, exactly so where all units
/// are measured equally well.
OutlierSearch find_outliers(const OutlierInput& input, double false_alarm = 0.01);

}  // namespace imulab
