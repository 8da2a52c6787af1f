// The effect of each source of error on an inertial solution over time: linear error dynamics along a motion.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/coefficient.hpp"
#include "imulab/eigen.hpp"
#include "imulab/grade.hpp"
#include "imulab/navigate.hpp"
#include "imulab/navigation/motion/trajectory.hpp"
#include "imulab/sensor_model.hpp"

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace imulab {

// The sources of error of an inertial solution: the sensors, the start, the barometer. Every size is one sigma of a draw, or fixed.

/// Errors of the start, in east-north-up axes: attitude [rad] (the computed attitude is (I - [error x]) C_nb), velocity [m/s], position [m].
struct StartErrors {
  std::array<Spread, 3> attitude{}, velocity{}, position{};
  /// In place of `attitude`: that of an alignment at rest over this time [s], which the sensors' own errors cause (levels: accelerometers;
  /// heading: gyros, unless `attitude` has a size of it: then it is given).
  std::optional<double> aligned_over;
  bool heading_given() const { return aligned_over && attitude[2].value != 0; }
};

/// Height reads true height + bias + a first-order Markov process.
struct BarometerErrors {
  Spread bias{};              // m
  double noise = 0;           // m, one sigma of the process
  double time_constant = 10;  // s, of the process
};

struct ErrorSources {
  SensorModel model;                                                   // what the navigator compensates with: the ideal unit, or a calibration
  std::vector<CoefficientIndex> coefficients;                          // table indices of those with an error
  Eigen::VectorXd fixed;                                               // the error of each [SI of the table]: exactly this,
  Eigen::MatrixXd covariance;                                          // and a draw with this covariance
  Vector3d accel_tau = Vector3d::Zero(), gyro_tau = Vector3d::Zero();  // thermal readings less their reference, throughout
  NoiseModel gyro_noise, accel_noise;                                  // of the compensated output
  StartErrors start;
  BarometerErrors barometer;
};

/// The errors that remain after a calibration: its model and its whole covariance, without lever arms, which `compensate` does not know. The noise is
/// zero: a calibration does not state it.
ErrorSources error_sources(const Calibration& calibration);

/// Rows: position [m], velocity [m/s], attitude [rad], each east, north, up.
inline constexpr int budget_quantities = 9;
using BudgetRows = Eigen::Matrix<double, budget_quantities, Eigen::Dynamic>;
using BudgetMatrix = Eigen::Matrix<double, budget_quantities, budget_quantities>;

/// The contribution of one source, a column for each output time: the error from what is fixed, and one sigma of what is drawn.
struct Contribution {
  std::string name;  // "gyro bias", or a coefficient's "gyro.offset.x"
  BudgetRows fixed, sigma;
};

/// The aids of a mission that are lost: the budget of an aided solution ends with their absence.
struct AidLoss {
  double begin = 0;               // s
  std::vector<std::string> aids;  // "gnss"
};

struct ErrorBudget {
  std::optional<AidLoss> loss = {};  // of an aided solution
  VerticalChannel vertical = VerticalChannel::free;
  std::vector<double> time;                // s
  std::vector<Contribution> groups;        // of coefficients, noise terms, start; they add up to the total, with the correlation between groups
  std::vector<Contribution> coefficients;  // one by one
  BudgetRows mean;
  std::vector<BudgetMatrix> covariance;
  /// Shares of the mean square error (mean^2 + variance) of a quantity: of each group, in their order, then of the correlation between groups. They
  /// add up to one; a source that partly cancels the others has a negative share.
  std::vector<double> shares(int quantity, std::size_t at) const;
  /// Shares of the horizontal position error; all zero where the error is zero.
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
