// All statistics of a fleet: the spread of its units, without the uncertainty of measurement; outliers; drift; differences between stations and
// between operators; whether production is steady and capable (docs/fleet.md).
#pragma once

#include "imulab/fleet/statistics/control.hpp"
#include "imulab/fleet/statistics/drift.hpp"
#include "imulab/fleet/statistics/gauge.hpp"
#include "imulab/fleet/statistics/outliers.hpp"
#include "imulab/fleet/statistics/random_effects.hpp"
#include "imulab/fleet/statistics/sample.hpp"
#include "imulab/model/requirement.hpp"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace imulab {

struct FleetOptions {
  double confidence = 0.95;                    ///< of every interval, each by itself
  double false_alarm = 0.01;                   ///< of outliers, and of significant drifts and correlations: of all together
  std::vector<Requirement> requirements = {};  ///< limits of the values
  std::vector<Requirement> errors = {};        ///< how large the errors of a calibration may become before the unit is due
};

/// When a unit is to be calibrated again, and the coefficient that requires it first.
struct UnitDue {
  Eigen::Index unit = 0;
  CoefficientIndex coefficient{};
  double time = 0;  ///< s since 1970; infinite: not within `due_horizon`. At or before the last calibration: that one does not meet the limit
};

struct CoefficientStatistics {
  CoefficientIndex index{};
  double size = 1;                 ///< SI of one user unit
  std::string unit;                ///< the user unit; SI where there is none
  RandomEffects fleet;             ///< of each unit's last calibration, without the outliers
  ControlChart chart;              ///< by `rows`
  std::vector<Eigen::Index> rows;  ///< of the sample: the last calibrations that have this coefficient, in the order of their times
  double control = 0;              ///< three standard deviations of a unit that is measured as well as the average
  std::optional<Capability> capability;
  FleetDrift drift;
  std::optional<RandomEffects> mean_drift;  ///< of the units' slopes, per year
  std::optional<Gauge> stations, operators;
  std::vector<UnitDue> due;  ///< each unit that has this coefficient; none where no error is limited, or no unit's drift is known
};

struct SignificantDrift {
  CoefficientIndex index;
  UnitDrift drift;
};

struct SignificantCorrelation {
  CoefficientIndex a, b;
  double correlation = 0;  ///< between units, without that of the measurement
};

struct FleetStatistics {
  FleetSample sample;
  std::vector<CoefficientStatistics> coefficients;
  OutlierSearch search;         ///< units: of the sample's `last`; columns: of its `common`
  Eigen::MatrixXd correlation;  ///< of `common` over the fleet; zero where a coefficient has no spread
  std::vector<SignificantCorrelation> correlations;
  std::vector<SignificantDrift> drifts;  ///< changes that the calibrations do not explain
  std::vector<UnitDue> due;              ///< the earliest first, each unit once
};

/// `covariance`: of the calibration in a row, of the sample's `common` columns; NaN where it has none. Works on all processors; the result does not
/// depend on their number.
FleetStatistics fleet_statistics(FleetSample sample, const std::function<Eigen::MatrixXd(Eigen::Index row)>& covariance,
                                 const FleetOptions& options = {});

}  // namespace imulab
