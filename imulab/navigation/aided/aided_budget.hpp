// The budget of an aided solution: the uncertainty of its filter along a known motion, without data, while its aids measure and after they are lost.
//
// The filter's transitions, rows and updates (docs/theory/aided.md) are linearized about the true motion. Its covariance is the sum over the error
// sources under the filter's gains: the start, each constant of the sensors and aids, each noise.
#pragma once

#include "imulab/aid.hpp"
#include "imulab/navigation/budget/budget.hpp"
#include "imulab/navigation/motion/trajectory.hpp"

#include <string>
#include <vector>

namespace imulab {

/// White part of the variance of an aid with correlated errors: a receiver's noise is below its slow errors.
inline constexpr double white_share = 0.1;

/// Options of a budget. The loss is the longest outage of the aids. Without an outage, receivers (or, if there are none, all aids with a record) are
/// lost for the last 600 s, but at most for the last third of the motion.
struct AidedBudgetOptions {
  double output_interval = 10;  // s while the aids measure; 1 s after the loss
};

/// Computes the budget. The records of `aids` must be on the clock of the motion; their values are not used. A fixed error counts as one sigma
/// because the filter has to estimate it. Noise follows the sources; errors of aids have their stated sizes. The budget ends with the loss. Throws
/// Error like navigate_aided and GrowingBudget, and if no aid can be lost.
ErrorBudget aided_budget(const motion::NominalMotion& motion, const ErrorSources& sources, const std::vector<Aid>& aids,
                         const AidedBudgetOptions& options = {});

/// Describes the sources for which the filter has no state; empty if there are none.
std::string beyond_aided_budget(const ErrorSources& sources);

}  // namespace imulab
