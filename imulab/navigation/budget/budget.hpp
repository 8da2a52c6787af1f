// The effect of each source of error on an inertial solution over time: linear error dynamics along a motion.
#pragma once

#include "imulab/navigation/budget/sources.hpp"
#include "imulab/navigation/integration/strapdown.hpp"
#include "imulab/navigation/motion/trajectory.hpp"

#include <Eigen/Core>

#include <memory>
#include <string>
#include <vector>

namespace imulab {

/// Rows: position [m], velocity [m/s], attitude [rad], each east, north, up.
inline constexpr int budget_quantities = 9;
using BudgetRows = Eigen::Matrix<double, budget_quantities, Eigen::Dynamic>;
using BudgetMatrix = Eigen::Matrix<double, budget_quantities, budget_quantities>;

/// Of one source, a column for each output time: the error from what is fixed, and one sigma of what is drawn.
struct Contribution {
  std::string name;  // "gyro bias", or a coefficient's "gyro.offset.x"
  BudgetRows fixed, sigma;
};

struct ErrorBudget {
  VerticalChannel vertical = VerticalChannel::free;
  std::vector<double> time;                // s
  std::vector<Contribution> groups;        // of coefficients, noise terms, start; they add up to the total, with the correlation between groups
  std::vector<Contribution> coefficients;  // one by one
  BudgetRows mean;
  std::vector<BudgetMatrix> covariance;
  /// Shares of the mean square error (mean^2 + variance) of a quantity: of each group, in their order, then of the correlation between groups. They
  /// add up to one; a source that partly cancels the others has a negative share.
  std::vector<double> shares(int quantity, std::size_t at) const;
  /// The same of the horizontal position; all zero where its error is.
  std::vector<double> horizontal_shares(std::size_t at) const;
};

struct BudgetOptions {
  StrapdownOptions strapdown = {};
  double output_interval = 10;  // s; the end is always among the outputs
  double block = 0.5;           // s: the sensors' errors are summed over it, and act in its middle; the error of the result grows with its square
  bool algorithm = true;        // integrate the motion again, for the integration's own error; false: the motion was integrated from these increments
};

/// The budget of a motion that arrives sample by sample, as error_budget gives it, without the integration's own error.
class GrowingBudget {
 public:
  /// From `start` at `begin` [s] on; the samples' nominal interval [s]. Throws Error for sources of inconsistent sizes, a covariance that is not
  /// positive, and a start or options that Strapdown refuses.
  GrowingBudget(double begin, double interval, const NavigationState& start, const ErrorSources& sources, const BudgetOptions& options = {});
  ~GrowingBudget();
  GrowingBudget(const GrowingBudget&) = delete;
  GrowingBudget& operator=(const GrowingBudget&) = delete;

  /// A sample's end [s], the state there, and what an ideal IMU reads until then. Throws Error for a time that is not after the one before.
  void add(double time, const NavigationState& state, const Increment& sample);
  /// Throws Error where there was no sample.
  ErrorBudget finish();

 private:
  struct Rows;
  std::unique_ptr<Rows> rows_;
};

/// First-order: valid while attitude errors stay below some milliradians and position errors below some hundredths of the Earth's radius. With
/// `aligned_over`, an alignment error belongs to the source that caused it: a bias and the tilt it causes cancel in part. Throws Error as
/// GrowingBudget does.
ErrorBudget error_budget(const motion::NominalMotion& motion, const ErrorSources& sources, const BudgetOptions& options = {});

}  // namespace imulab
