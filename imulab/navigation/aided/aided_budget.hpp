// The budget of an aided solution: what its filter would state along a known motion, without data, while its aids measure and after they are lost.
//
// The filter's own transitions, rows and updates (docs/theory/aided.md) are linearized about the true motion. Its covariance is the sum of what each
// source of error leaves under the filter's gains: the start, each constant of the sensors and aids, each noise.
#pragma once

#include "imulab/aid.hpp"
#include "imulab/navigation/budget/budget.hpp"
#include "imulab/navigation/motion/trajectory.hpp"

#include <string>
#include <vector>

namespace imulab {

/// Of the variance of an aid with correlated errors, the part that is white: a receiver's noise is below its slow errors.
inline constexpr double white_share = 0.1;

/// The loss is the longest of the aids' outages. Without one the receivers, or without these all aids with a record, are lost for the last 600 s,
/// at most the last third of the motion.
struct AidedBudgetOptions {
  double output_interval = 10;  // s while the aids measure; after the loss it is one second
};

/// `aids` have their records on the motion's clock; what these measured does not matter. A fixed error counts as one sigma: the filter does not know
/// it. Noise is that of the sources, and sizes of aids those that they state. The budget ends with the loss. Throws Error as navigate_aided and
/// GrowingBudget do, and where no aid can be lost.
ErrorBudget aided_budget(const motion::NominalMotion& motion, const ErrorSources& sources, const std::vector<Aid>& aids,
                         const AidedBudgetOptions& options = {});

/// What sources there are that the filter has no state for, in words; empty: none.
std::string beyond_aided_budget(const ErrorSources& sources);

}  // namespace imulab
