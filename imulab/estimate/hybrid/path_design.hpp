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
  Plan unit;                   ///< site, noise and terms; its steps are ignored
  std::vector<RigAxis> axes;   ///< that can be turned about
  double turn_rate = 0;        ///< rad/s
  std::optional<double> time;  ///< s in all; absent: as short as the requirements allow
  std::optional<double> rest;  ///< s, of every rest; absent: chosen, rest by rest
};

struct Path {
  double first_rest = 0;  ///< s
  std::vector<TableTurn> turns;
  double duration = 0;  ///< s
  double worst = 0;     ///< largest ratio of a coefficient's sigma to its requirement; one that is not determined has its prior's sigma
  CoefficientIndex worst_coefficient{-1};
};

/// Finds, among all examined paths from zero angles, the shortest with a `worst` of at most 1, or the one with the smallest `worst` in the given time. Where
/// no path up to `longest_path` reaches 1, the one with the smallest. `progress`: percent done. `shared`: by processes that share the search.
/// Bit-equal on any number of threads and processes.
Path design_path(const PathQuestion& question, const std::function<void(int)>& progress = {}, const Checkpoint* shared = nullptr);

inline constexpr double longest_path = 4 * 3600.0;  // s

/// The uncertainty of a scale from nonlinearity that no path shows, at turns of this rate [rad/s]; 0 for other coefficients.
double nonlinear_sigma(const Plan& unit, CoefficientIndex index, double turn_rate);
/// The uncertainty that no path reduces: the one above, and for an accelerometer's scale also that of gravity.
double least_sigma(const Plan& unit, CoefficientIndex index, double turn_rate);

}  // namespace imulab::hybrid
