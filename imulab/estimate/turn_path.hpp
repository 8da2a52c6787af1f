// The interface of methods that plan their own procedure (docs/reference/predict.md).
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

/// Functions for planning; null if the method has no plan. `unit` provides site and IMU; its steps are ignored.
struct PathPlanner {
  /// Throws Error if the method does not estimate a required coefficient.
  void (*expect_estimated)(const std::vector<Requirement>& requirements, const Session& unit) = nullptr;
  /// Returns the uncertainty that no path reduces, for turns at this rate [rad/s].
  double (*least_sigma)(const Session& unit, CoefficientIndex index, double turn_rate) = nullptr;
  /// Searches all examined paths from zero angles for the shortest with a `worst` of at most 1, or for the one with the smallest `worst` in the given
  /// time. If no path up to `longest_path` reaches 1, returns the one with the smallest `worst`. `progress` is called with percent done; `sharing`
  /// distributes the search. Results are bit-identical for any number of threads and parts.
  TurnPath (*design)(const PathLimits& limits, const Session& unit, const std::function<void(int)>& progress, const Sharing* sharing) = nullptr;
};

}  // namespace imulab
