// The course of a turntable fit: weights and linearisation from the readings themselves, a reversed axis recognised, wrong steps left out.
#pragma once

#include "imulab/core/statistics.hpp"
#include "imulab/estimate/turntable_estimator.hpp"

#include <algorithm>
#include <string>
#include <vector>

namespace imulab {

inline constexpr double by_chance = 1e-3;  ///< what happens less often by chance is said

struct TurntableProblem {
  const TableObservations& seen;
  const TableMotion& motion;
  const ImuDeclaration& imu;
  Eigen::VectorXd values;
};

struct TurntableFit {
  TurntableEstimator estimator;
  Eigen::VectorXd readings;  ///< linearised
  SensorModel model;
  double chi2;
  double log_probability() const { return log_chi_square_tail(chi2, std::max(1, estimator.degrees_of_freedom())); }
};

/// Sensors' noise alone sets the first weights; then the table's errors are brought to raw readings with the model found, and the motion is linear
/// about the table errors found. Throws Unsupported where the readings do not follow the motion.
TurntableFit fit_turntable(const TurntableProblem& problem, TurntableSettings settings);

/// Where the readings contradict the steps: which axis turns the other way, in words. Empty if none.
std::string reversed_axis(const TurntableProblem& problem, const TurntableFit& fit, const RigDeclaration& rig, const Site& site,
                          const TurntableSettings& settings);

/// Leaves steps out one by one, the least probable first, if that makes the others agree; if not, the noise or the table is worse than declared.
struct CleanedFit {
  TurntableFit fit;
  std::vector<std::string> dropped;
  std::string worst;  ///< the least probable step where leaving out does not help
};

CleanedFit drop_outliers(const TurntableProblem& problem, const TurntableFit& fit, TurntableSettings& settings, double level);

}  // namespace imulab
