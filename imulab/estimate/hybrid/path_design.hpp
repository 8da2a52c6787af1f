// The path of a hybrid calibration: the turns of 90 and 180 deg and the rests between them that reach required uncertainties in the shortest time, or
// the smallest uncertainties in a given time (docs/plan.md).
#pragma once

#include "imulab/core/shared_work.hpp"
#include "imulab/estimate/hybrid/prediction.hpp"
#include "imulab/model/requirement.hpp"
#include "imulab/rig/procedure.hpp"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace imulab::hybrid {

struct PathQuestion {
  std::vector<Requirement> requirements;
  Plan unit;                   ///< site, noise and terms; its steps do not count
  std::vector<RigAxis> axes;   ///< that can be turned about
  double turn_rate = 0;        ///< rad/s
  std::optional<double> time;  ///< s in all; absent: as short as the requirements allow
  std::optional<double> rest;  ///< s, of every rest; absent: chosen, rest by rest
};

/// Processes that share a search: where, and a text that is another one for every other question.
struct SharedSearch {
  Checkpoint checkpoint;
  std::string identity;
};

struct Path {
  double first_rest = 0;  ///< s
  std::vector<TableTurn> turns;
  double duration = 0;  ///< s
  double worst = 0;     ///< largest ratio of a coefficient's sigma to its requirement; one that is not determined counts with its prior
  CoefficientIndex worst_coefficient{-1};
};

/// Of all paths from zero angles that it looks at, the shortest with a `worst` of at most 1, or that with the least `worst` in the given time. Where
/// no path of `longest_path` reaches 1, that with the least. `progress`: parts of a hundred that are done. Bit-equal on any number of threads and
/// processes.
Path design_path(const PathQuestion& question, const std::function<void(int)>& progress = {}, const SharedSearch* shared = nullptr);

inline constexpr double longest_path = 4 * 3600.0;  // s

/// What nonlinearity of which no path says anything counts in a scale, at turns of this rate [rad/s]; 0 of other coefficients.
double nonlinear_sigma(const Plan& unit, CoefficientIndex index, double turn_rate);
/// The uncertainty that no path reduces: that, and of an accelerometer's scale gravity's.
double least_sigma(const Plan& unit, CoefficientIndex index, double turn_rate);

}  // namespace imulab::hybrid
