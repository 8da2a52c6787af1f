// A path of turns and rests: the answer of a method that can plan its own procedure (docs/plan.md).
#pragma once

#include "imulab/core/shared_work.hpp"
#include "imulab/estimate/prediction.hpp"
#include "imulab/recording/session.hpp"
#include "imulab/rig/procedure.hpp"

#include <functional>
#include <optional>
#include <vector>

namespace imulab {

inline constexpr double longest_path = 4 * 3600.0;  // s

/// The bounds of a search.
struct PathLimits {
  std::vector<Requirement> requirements;
  std::vector<RigAxis> axes;        ///< that can be turned about
  double turn_rate = 0;             ///< rad/s
  std::optional<double> time = {};  ///< s in all; absent: as short as the requirements allow
  std::optional<double> rest = {};  ///< s, of every rest; absent: chosen, rest by rest
};

struct TurnPath {
  double first_rest = 0;  ///< s
  std::vector<TableTurn> turns;
  double duration = 0;  ///< s
  double worst = 0;     ///< largest ratio of a coefficient's sigma to its requirement; one that is not determined has its prior's sigma
  CoefficientIndex worst_coefficient{-1};
};

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
