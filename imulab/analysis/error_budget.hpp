// What each source of error does to an inertial solution over time: linear error dynamics along a motion.
#pragma once

#include "imulab/analysis/error_growth.hpp"
#include "imulab/analysis/error_sources.hpp"

#include <Eigen/Core>

#include <string>
#include <vector>

namespace imulab {

/// Rows of what follows: position [m], velocity [m/s], attitude [rad], each east, north, up.
inline constexpr int budget_quantities = 9;
using BudgetRows = Eigen::Matrix<double, budget_quantities, Eigen::Dynamic>;
using BudgetMatrix = Eigen::Matrix<double, budget_quantities, budget_quantities>;

/// Of one source, a column for each output time: the error of what is fixed, and one sigma of what is drawn.
struct Contribution {
  std::string name;  // "gyro bias", or a coefficient's "gyro.offset.x"
  BudgetRows fixed, sigma;
};

struct ErrorBudget {
  VerticalChannel vertical = VerticalChannel::free;
  std::vector<double> time;                // s
  std::vector<Contribution> groups;        // readable; they make up the total, and "correlation between groups" where there is one
  std::vector<Contribution> coefficients;  // one by one
  BudgetRows mean;
  std::vector<BudgetMatrix> covariance;
  /// By group, in their order, then of the correlation between groups: of the mean square error (mean^2 + variance) of a quantity. They add up to
  /// one; a source that works against the others has a negative share.
  std::vector<double> shares(int quantity, std::size_t at) const;
};

struct BudgetOptions {
  StrapdownOptions strapdown = {};
  double output_interval = 10;  // s; the end is always among the outputs
  double block = 0.5;           // s: the sensors' errors are summed over it, and act in its middle; the result errs by its square
};

/// With `aligned_over` what the alignment owes to a source belongs to that source: a bias and the tilt it causes cancel in part.
ErrorBudget error_budget(const NominalMotion& motion, const ErrorSources& sources, const BudgetOptions& options = {});

/// Error state at the end by source.
ErrorColumns error_sensitivities(const NominalMotion& motion, const ErrorSources& sources, const BudgetOptions& options = {});

}  // namespace imulab
