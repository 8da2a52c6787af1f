// How a method plans its own procedure (docs/reference/predict.md).
#pragma once

#include "imulab/core/shared_work.hpp"
#include "imulab/estimate/prediction.hpp"
#include "imulab/plan.hpp"
#include "imulab/procedure.hpp"
#include "imulab/session.hpp"

#include <functional>
#include <optional>
#include <vector>

namespace imulab {

/// The functions with which a method plans; null where it does not. `unit` is a procedure whose site and IMU count, not its steps.
struct PathPlanner {
  /// Throws Error where a required coefficient is not among those that the method estimates.
  void (*expect_estimated)(const std::vector<Requirement>& requirements, const Session& unit) = nullptr;
  /// The uncertainty that no path reduces, with turns of this rate [rad/s].
  double (*least_sigma)(const Session& unit, CoefficientIndex index, double turn_rate) = nullptr;
  /// Finds, among all examined paths from zero angles, the shortest with a `worst` of at most 1, or the one with the smallest `worst` in the given
  /// time. Where no path up to `longest_path` reaches 1, the one with the smallest. `progress`: percent done. `sharing`: of the
  /// search. Bit-equal on any number of threads, and from parts.
  TurnPath (*design)(const PathLimits& limits, const Session& unit, const std::function<void(int)>& progress, const Sharing* sharing) = nullptr;
};

}  // namespace imulab
