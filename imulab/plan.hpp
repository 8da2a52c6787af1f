// Plans turns and rests for the method "hybrid": a path with required uncertainties in the shortest time, or with the smallest uncertainties in a
// given time (docs/reference/predict.md).
//
// Example:
//   const Session unit = turns_procedure("unit", 60, {}, {.grade = "navigation"});
//   const TurnPath path = plan_path(unit, {.requirements = parse_requirements("gyro.offset <= 0.01 deg/h"),
//                                          .axes = {RigAxis::middle, RigAxis::inner}, .turn_rate = 10 * unit::deg});
//   const Session procedure = turns_procedure("plan", path.first_rest, path.turns, {.grade = "navigation"});
//
// The search models white noise only. Check the procedure with `predict`, which includes slow noise and effects; `imulab plan` tightens the limits
// accordingly. A search takes seconds on all threads; its result does not depend on their number.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/procedure.hpp"
#include "imulab/session.hpp"

#include <functional>
#include <optional>
#include <vector>

namespace imulab {

inline constexpr double longest_path = 4 * 3600.0;  // s

/// The limits of a search.
struct PathLimits {
  std::vector<Requirement> requirements = {};
  std::vector<RigAxis> axes = {};   ///< axes about which the unit can be turned
  double turn_rate = 0;             ///< rad/s
  std::optional<double> time = {};  ///< total time [s]; absent: as short as the requirements allow
  std::optional<double> rest = {};  ///< duration of every rest [s]; absent: chosen for each rest
};

struct TurnPath {
  double first_rest = 0;  ///< s
  std::vector<TableTurn> turns = {};
  double duration = 0;  ///< s
  /// Largest ratio of a coefficient's sigma to its requirement; a coefficient that is not determined has the sigma of its prior.
  double worst = 0;
  CoefficientIndex worst_coefficient{-1};
};

/// Searches all examined paths from zero angles for the shortest with a `worst` of at most 1, or for the one with the smallest `worst` in the given
/// time. If no path up to `longest_path` reaches 1, returns the one with the smallest `worst`. `unit` provides site and IMU; its steps are ignored.
/// `limits`: requirements, axes, turn rate and times. `progress` is called with percent done. Results are bit-identical for any number of threads.
/// Throws Error if the hybrid method does not estimate a required coefficient.
TurnPath plan_path(const Session& unit, const PathLimits& limits, const std::function<void(int)>& progress = {});

}  // namespace imulab
