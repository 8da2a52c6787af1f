// Predicted uncertainties and tolerances of a procedure as tables.
#pragma once

#include "imulab/predict.hpp"

#include <string>
#include <vector>

namespace imulab {

struct TurnPath;

/// One unit for all coefficients of a term, by the largest of them; the readings are those of an ideal IMU, in SI.
UserUnit unit_of(CoefficientIndex index, const std::vector<CoefficientIndex>& coefficients, const Eigen::VectorXd& sigma);
/// The sigma of a coefficient; NaN where it is not among the predicted ones.
double sigma_of(CoefficientIndex index, const std::vector<CoefficientIndex>& coefficients, const Eigen::VectorXd& sigma);

/// The worst of each group, then a row a coefficient: its uncertainty in user units, and beside it the share of each source in its variance where the
/// method tells them apart, else what is required. With `details` also orders and Monte Carlo with more digits.
std::string prediction_table(const Prediction& prediction, const std::vector<Requirement>& requirements, bool details = false);

/// Which requirements the procedure does not meet as declared, and what table, timing and unit would meet them all.
std::string tolerance_table(const Tolerances& tolerances, const std::vector<Shortfall>& missed);
/// The worst determined coefficients, and the turns that help most.
std::string advice_text(const Advice& advice);
/// The further turns of an advice: "turn by ..., then turn by ..., and rest".
std::string turns_text(const Advice& advice);
/// "gyro.matrix.xx has 31.2 ppm where 10 ppm is required" or "gyro.matrix.xx is not determined".
std::string shortfall_text(const Shortfall& shortfall);

/// A fleet's prior, and the shortest path without it (NaN where the time was given).
struct PriorEffect {
  std::string fleet;
  double units = 0, duration_without = 0;  ///< s
};

/// "with what 60 units of fleet.db say of it; without: 14 min 05 s"
std::string prior_text(const PriorEffect& prior);
/// First rest, then a row a turn and the rest after it.
std::string path_table(const TurnPath& path);

}  // namespace imulab
