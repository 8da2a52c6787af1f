// Change of units over time: a line through each unit's calibrations, against their uncertainties and what a unit repeats to from one to the next.
#pragma once

#include "imulab/eigen.hpp"
#include "imulab/fleet.hpp"

#include <vector>

namespace imulab {

/// Calibrations of one coefficient, in any order; of the fleet's unit `unit[k]`, 0 to the number of units less one.
struct DriftInput {
  std::vector<Eigen::Index> unit;
  Eigen::ArrayXd time;  ///< years
  Eigen::ArrayXd values, variances;
};

/// Weighted least squares; the repeatability is one for all units, of their residuals together (Mandel and Paule 1970). Where it is above zero the
/// intervals are those of Student's distribution.
FleetDrift fleet_drift(const DriftInput& input, double confidence = 0.95);

// When a unit is to be calibrated again: before its drift makes an error larger than it may be.

/// The line through one coefficient of a unit's calibrations, whose level and slope have independent errors at their weighted middle, and the
/// distance of the last calibration, which compensates the unit, from it.
struct Aging {
  double level = 0, level_sigma = 0;  ///< at the middle, less the value of the last calibration
  double since_middle = 0;            ///< years, from there to the last calibration
  double repeatability = 0;           ///< standard deviation of the unit about its line, from one occasion to the next
  double slope = 0, slope_sigma = 0;  ///< per year
};

/// Years until the error of the last calibration may be as large as `limit`, at 95 %: the first t, with s = since_middle + t, of
///   |level + d s| + 1.96 sqrt(u_level^2 + r^2 + (u_d s)^2) = limit.
/// 0: the calibration itself is not that good; infinite: not within `due_horizon` years.
double years_until(const Aging& aging, double limit);
inline constexpr double due_horizon = 20;

/// A unit's slope, measured or not, among those of its fleet: mean and variance of the fleet's slopes, and the unit's own with its variance
/// (infinite: it has none). Mean and variance of the product.
struct Slope {
  double mean = 0, variance = 0;
};
/// The distribution of a fleet's slopes: their mean, and as its variance the upper end of the spread's interval: few units often show none at all.
Slope slopes_of(const RandomEffects& slopes);
Slope slope_among(const Slope& fleet, const Slope& own);

}  // namespace imulab
