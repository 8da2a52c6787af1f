// What a procedure for the hybrid method leaves open, and which turn would show it.
#pragma once

#include "imulab/analysis/hybrid_prediction.hpp"
#include "imulab/analysis/requirement.hpp"
#include "imulab/rig/procedure.hpp"

#include <span>
#include <string>
#include <vector>

namespace imulab {

/// The worst-determined direction: a combination of coefficients, each in what is required of it (or half of what is known of it beforehand), and the
/// further turns, one or two of 90 or 180 deg about the table's axes at the end of the procedure, that help most.
struct HybridAdvice {
  std::vector<int> coefficients;   ///< with a large part in it, table indices, the largest first
  double ratio = 0;                ///< sigma along it, in what is required
  std::vector<std::string> turns;  ///< "turn by 180 deg about the unit's z axis while it is horizontal"; each with a rest after it
  double ratio_after = 0;          ///< the largest ratio with them
};

HybridAdvice advise(const HybridPlan& plan, const HybridPrediction& prediction, const std::vector<Requirement>& requirements = {});

/// Turns of a table from zero angles in the unit's own terms, as above.
std::vector<std::string> in_words(std::span<const TableTurn> turns);

/// Of a prediction, in the order of the requirements: the coefficients that are not within them, each once; sigma infinite where it is not
/// determined.
std::vector<Shortfall> shortfalls(const HybridPrediction& prediction, const std::vector<Requirement>& requirements);
/// Throws Error where a required coefficient is not among those that the method estimates of this unit.
void expect_estimated(const std::vector<Requirement>& requirements, const HybridPlan& plan);

}  // namespace imulab
