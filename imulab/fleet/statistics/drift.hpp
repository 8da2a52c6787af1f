// How units change: a line through each unit's calibrations, against their uncertainties and what a unit repeats to from one to the next.
#pragma once

#include <Eigen/Core>

#include <vector>

namespace imulab {

/// Calibrations of one coefficient, in any order; of the fleet's unit `unit[k]`, 0 to the number of units less one.
struct DriftInput {
  std::vector<Eigen::Index> unit;
  Eigen::ArrayXd time;  ///< years
  Eigen::ArrayXd values, variances;
};

struct UnitDrift {
  Eigen::Index unit = 0;
  int calibrations = 0;
  double span = 0;                      ///< years, from the first to the last
  double slope = 0, low = 0, high = 0;  ///< per year, with its interval
  double uncertainty = 0;               ///< standard, of the slope
  double since_middle = 0;              ///< years from the calibrations' weighted middle to the last; there level and slope have independent errors
  double level = 0, level_uncertainty = 0;
  double p_value = 1;  ///< of so large a slope without a drift
  double last = 0;     ///< the line's value at the last calibration
};

struct FleetDrift {
  double repeatability = 0;  ///< standard deviation of a unit about its line, beyond the uncertainties: turn-on, handling
  double degrees_of_freedom = 0;
  double p_value = 1;            ///< of such scatter about the lines by the uncertainties alone
  std::vector<UnitDrift> units;  ///< those with calibrations at two times or more
};

/// Weighted least squares; the repeatability is one for all units, of their residuals together (Mandel and Paule 1970). Where it is above zero the
/// intervals are those of Student's distribution.
FleetDrift fleet_drift(const DriftInput& input, double confidence = 0.95);

}  // namespace imulab
