// A path of turns and rests that reaches required uncertainties in the shortest time, or the smallest ones in a given time, for the method "hybrid"
// (docs/reference/predict.md).
//
// Example:
//   const Session unit = turns_procedure("unit", 60, {}, {.grade = "navigation"});
//   const TurnPath path = plan_path(unit, {.requirements = parse_requirements("gyro.offset <= 0.01 deg/h"),
//                                          .axes = {RigAxis::middle, RigAxis::inner}, .turn_rate = 10 * unit::deg});
//   const Session procedure = turns_procedure("plan", path.first_rest, path.turns, {.grade = "navigation"});
//
// The search knows white noise alone: check the procedure by `predict`, which also has slow noise and effects; `imulab plan` tightens the limits by
// what these add. A search takes seconds on all threads; its result does not depend on their number.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/procedure.hpp"
#include "imulab/session.hpp"

#include <functional>
#include <optional>
#include <vector>

namespace imulab {

inline constexpr double longest_path = 4 * 3600.0;  // s

/// The bounds of a search.
struct PathLimits {
  std::vector<Requirement> requirements = {};
  std::vector<RigAxis> axes = {};   ///< that can be turned about
  double turn_rate = 0;             ///< rad/s
  std::optional<double> time = {};  ///< s in all; absent: as short as the requirements allow
  std::optional<double> rest = {};  ///< s, of every rest; absent: chosen, rest by rest
};

struct TurnPath {
  double first_rest = 0;  ///< s
  std::vector<TableTurn> turns = {};
  double duration = 0;  ///< s
  double worst = 0;     ///< largest ratio of a coefficient's sigma to its requirement; one that is not determined has its prior's sigma
  CoefficientIndex worst_coefficient{-1};
};

/// Finds, among all examined paths from zero angles, the shortest with a `worst` of at most 1, or the one with the smallest `worst` in the given
/// time. Where no path up to `longest_path` reaches 1, the one with the smallest. `unit` is a procedure whose site and IMU count, not its steps.
/// `progress`: percent done. Bit-equal on any number of threads. Throws Error where a required coefficient is not among those that the hybrid method
/// estimates.
TurnPath plan_path(const Session& unit, const PathLimits& limits, const std::function<void(int)>& progress = {});

}  // namespace imulab
