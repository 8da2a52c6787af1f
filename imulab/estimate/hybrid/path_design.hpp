// The path of a hybrid calibration: turns of 90 and 180 deg and rests between them that reach required uncertainties in the shortest time, or the
// smallest uncertainties in a given time (docs/reference/predict.md).
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/core/shared_work.hpp"
#include "imulab/estimate/hybrid/prediction.hpp"
#include "imulab/estimate/turn_path.hpp"
#include "imulab/plan.hpp"
#include "imulab/procedure.hpp"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace imulab::hybrid {

struct PathQuestion : PathLimits {
  Plan unit;  ///< site, noise and terms; its steps are ignored
};

/// Designs a path like PathPlanner::design.
TurnPath design_path(const PathQuestion& question, const std::function<void(int)>& progress = {}, const Sharing* sharing = nullptr);

/// Returns the uncertainty of a scale due to nonlinearity that no path determines, for turns at this rate [rad/s]; 0 for other coefficients.
double nonlinear_sigma(const Plan& unit, CoefficientIndex index, double turn_rate);
/// Returns the uncertainty that no path can reduce: nonlinear_sigma and, for an accelerometer scale, the uncertainty of gravity.
double least_sigma(const Plan& unit, CoefficientIndex index, double turn_rate);

/// The functions of the method's row in the table.
inline constexpr PathPlanner planner{
    .expect_estimated = [](const std::vector<Requirement>& requirements, const Session& unit) { expect_estimated(requirements, plan_of(unit)); },
    .least_sigma = [](const Session& unit, CoefficientIndex index, double turn_rate) { return least_sigma(plan_of(unit), index, turn_rate); },
    .design =
        [](const PathLimits& limits, const Session& unit, const std::function<void(int)>& progress, const Sharing* sharing) {
          return design_path({limits, plan_of(unit)}, progress, sharing);
        }};

}  // namespace imulab::hybrid
