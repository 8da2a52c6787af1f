// The least determined coefficients of a procedure for the hybrid method, and the turns that would help.
#pragma once

#include "imulab/estimate/hybrid/prediction.hpp"
#include "imulab/model/requirement.hpp"
#include "imulab/rig/procedure.hpp"

#include <span>
#include <string>
#include <vector>

namespace imulab::hybrid {

/// The worst-determined direction: a combination of coefficients, each in units of its requirement (or of half its prior), and the further turns, one
/// or two of 90 or 180 deg about the table's axes at the end of the procedure, that help most.
struct Advice {
  std::vector<CoefficientIndex> coefficients;  ///< with a large part in it, the largest first
  double ratio = 0;                            ///< sigma along it, in those units
  std::vector<std::string> turns;              ///< "turn by 180 deg about the unit's z axis while it is horizontal"; each with a rest after it
  double ratio_after = 0;                      ///< the largest ratio with them
};
Advice advise(const Plan& plan, const Prediction& prediction, const std::vector<Requirement>& requirements = {});

/// Turns of a table from zero angles in the IMU's own terms, as above.
std::vector<std::string> in_words(std::span<const TableTurn> turns);

/// In the order of the requirements: the coefficients that exceed them, each once; sigma is infinite if not determined.
std::vector<Shortfall> shortfalls(const Prediction& prediction, const std::vector<Requirement>& requirements);
/// Throws Error where a required coefficient is not among those that the method estimates.
void expect_estimated(const std::vector<Requirement>& requirements, const Plan& plan);

}  // namespace imulab::hybrid
