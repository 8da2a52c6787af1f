// The effect of each error source on an inertial solution over time, by linear error dynamics along a motion.
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

// The error sources of an inertial solution: sensors, start, barometer. Every size is one sigma of a draw, or fixed.

/// Errors of the start, east-north-up: attitude [rad] (the computed attitude is (I - [error x]) C_nb), velocity [m/s], position [m].
struct StartErrors {
  std::array<Spread, 3> attitude{}, velocity{}, position{};
  /// Replaces `attitude` by the result of an alignment at rest over this time [s] with the errors of the sensors: level from accelerometers, heading
  /// from gyros, or with the size in `attitude` if that is nonzero (a given heading).
  std::optional<double> aligned_over;
  bool heading_given() const { return aligned_over && attitude[2].value != 0; }
};

/// Errors of a barometer, whose reading is the true height plus a bias and a first-order Markov process.
struct BarometerErrors {
  Spread bias{};              // m
  double noise = 0;           // m, one sigma of the process
  double time_constant = 10;  // s, of the process
};

struct ErrorSources {
  SensorModel model;                                                   // compensation of the navigator: ideal unit, or a calibration
  std::vector<CoefficientIndex> coefficients;                          // table indices of coefficients with an error
  Eigen::VectorXd fixed;                                               // exact error of each [SI of the table],
  Eigen::MatrixXd covariance;                                          // plus a random error with this covariance
  Vector3d accel_tau = Vector3d::Zero(), gyro_tau = Vector3d::Zero();  // thermal readings minus their reference, constant
  NoiseModel gyro_noise, accel_noise;                                  // noise of the compensated output
  StartErrors start;
  BarometerErrors barometer;
};

/// Returns the errors that remain after a calibration: its model and complete covariance, without lever arms, which `compensate` does not use. The
/// noise is zero because a calibration does not state it.
ErrorSources error_sources(const Calibration& calibration);

/// Number of rows: position [m], velocity [m/s], attitude [rad], each east, north, up.
inline constexpr int budget_quantities = 9;
using BudgetRows = Eigen::Matrix<double, budget_quantities, Eigen::Dynamic>;
using BudgetMatrix = Eigen::Matrix<double, budget_quantities, budget_quantities>;

/// The contribution of one source, one column per output time: the error due to fixed sizes, and one sigma due to random ones.
struct Contribution {
  std::string name;  // "gyro bias", or a coefficient such as "gyro.offset.x"
  BudgetRows fixed, sigma;
};

/// Aids of a mission that are lost: the budget of an aided solution ends without them.
struct AidLoss {
  double begin = 0;               // s
  std::vector<std::string> aids;  // "gnss"
};

struct ErrorBudget {
  std::optional<AidLoss> loss = {};  // present for an aided solution
  VerticalChannel vertical = VerticalChannel::free;
  std::vector<double> time;                // s
  std::vector<Contribution> groups;        // coefficients, noise terms, start; with the correlation between groups, they add up to the total
  std::vector<Contribution> coefficients;  // single coefficients
  BudgetRows mean;
  std::vector<BudgetMatrix> covariance;
  /// Returns the fractions of the mean square error (mean^2 + variance) of a quantity: of each group in order, then of the correlation between
  /// groups. They sum to one; a source that partly cancels others has a negative fraction.
  std::vector<double> shares(int quantity, std::size_t at) const;
  /// Returns the fractions of the horizontal position error; all zero if the error is zero.
  std::vector<double> horizontal_shares(std::size_t at) const;
};

struct BudgetOptions {
  StrapdownOptions strapdown = {};
  double output_interval = 10;  // s; the end is always an output
  double block = 0.5;           // s: sensor errors are summed over a block and act at its middle; the error of the result grows with its square
  bool algorithm = true;  // integrates the motion again to find the integration's own error; false: the motion was integrated from these increments
};

/// Computes the budget of a motion that arrives sample by sample, like error_budget, without the integration's own error.
class GrowingBudget {
 public:
  /// Starts with the state `start` at `begin` [s]; `interval` is the nominal sample interval [s]. Throws Error if sources have inconsistent sizes, a
  /// covariance is not positive, or Strapdown refuses the start or the options.
  GrowingBudget(double begin, double interval, const NavigationState& start, const ErrorSources& sources, const BudgetOptions& options = {});
  ~GrowingBudget();
  GrowingBudget(const GrowingBudget&) = delete;
  GrowingBudget& operator=(const GrowingBudget&) = delete;

  /// Adds a sample: its end [s], the state there, and the ideal IMU's reading. Throws Error unless the time is after the previous one.
  void add(double time, const NavigationState& state, const Increment& sample);
  /// Returns the budget. Throws Error if there was no sample.
  ErrorBudget finish();

 private:
  struct Rows;
  std::unique_ptr<Rows> rows_;
};

/// Computes a first-order budget, valid while attitude errors are below some milliradians and position errors below some hundredths of the Earth's
/// radius. With `aligned_over`, an alignment error belongs to its source: a bias and the resulting tilt partly cancel. Throws Error like
/// GrowingBudget.
ErrorBudget error_budget(const motion::NominalMotion& motion, const ErrorSources& sources, const BudgetOptions& options = {});

}  // namespace imulab
