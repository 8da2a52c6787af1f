// Sensitivities to every source of error, and the covariance from noise, along a motion.
#pragma once

#include "imulab/navigation/budget/budget.hpp"
#include "imulab/navigation/budget/error_dynamics.hpp"
#include "imulab/navigation/budget/source_effects.hpp"

#include <optional>
#include <string>
#include <vector>

namespace imulab::budget {

/// First columns of the sensitivities: of the coefficients; of an error at one of each gyro and accelerometer after compensation (turn-on); of one
/// that grows by one a second; of the start's position, velocity and attitude; of the barometer's bias.
struct SourceColumns {
  Eigen::Index coefficients, gyro_unit = coefficients, accel_unit = gyro_unit + 3, gyro_ramp = accel_unit + 3, accel_ramp = gyro_ramp + 3,
                             start = accel_ramp + 3, barometer = start + 9, count = barometer + 1;
};

struct NoiseSource {
  enum class Acts { gyro_white, accel_white, gyro, accel, barometer } acts;
  std::string name;
  NoiseGrowth growth;
  double quantization = 0;  // Q, where it is that
};

/// When a result is due: at the first sample at or after each multiple of `interval` [s] from the start.
class Outputs {
 public:
  /// Throws Error for an interval that is not above 0.
  Outputs(double begin, double interval);
  /// True if a result is due at the next sample.
  bool due(double time);

 private:
  double begin_, interval_, next_;
};

/// Follows a motion sample by sample. Over each block of samples the sensors' errors are summed, and act in its middle.
class ErrorGrowth {
 public:
  /// Throws Error as GrowingBudget does.
  ErrorGrowth(double begin, double interval, const NavigationState& start, const ErrorSources& sources, const BudgetOptions& options);
  /// From the start of this motion.
  ErrorGrowth(const motion::NominalMotion& motion, const ErrorSources& sources, const BudgetOptions& options);

  /// Adds a sample; true if a result is due here: the block has ended then. Throws Error for a time that is not after the one before.
  bool add(double time, const NavigationState& state, const Increment& sample);
  /// Ends the last block; true if it has a result that was not due before. Throws Error where there was no sample.
  bool finish();
  double time() const { return block_.time.back(); }

  const SourceColumns& columns() const { return columns_; }
  /// Derivative of the present error state by each source. What a source does through an alignment is in its column.
  ErrorColumns sensitivities() const;
  std::size_t noises() const { return noises_.size(); }
  const std::string& noise_name(std::size_t i) const { return noises_[i].name; }
  ErrorMatrix noise_covariance(std::size_t i) const;

 private:
  void start();
  void align(const StartErrors& errors);
  void quantize(NoiseSource& noise, const StartErrors& errors);
  void add_unit(const ErrorColumns& gyro, const ErrorColumns& accel, double time);
  void end_block();

  double begin_;
  NavigationState start_;
  motion::NominalMotion block_;  // not ended
  double longest_block_;         // s
  Outputs outputs_;
  bool any_ = false;
  StrapdownOptions options_;
  CoefficientEffects effects_;
  SourceColumns columns_;
  ErrorColumns sensitivity_;
  std::vector<NoiseSource> noises_;
  double aligned_ = 0;  // s before the motion
};

/// What a budget calls the sources of a coefficient's kind: "gyro misalignment".
std::string group_of(const Coefficient& c);

/// Throws Error for a motion without samples, of parts that do not fit, or of times that do not ascend.
void check(const motion::NominalMotion& motion);

/// Derivative of the error state at the end by each source.
ErrorColumns error_sensitivities(const motion::NominalMotion& motion, const ErrorSources& sources, const BudgetOptions& options = {});

/// Numbers of the samples at which a result is due: the first at or after each multiple of `interval` [s] from the start, and the last.
std::vector<std::size_t> output_samples(const motion::NominalMotion& motion, double interval);

/// The effect of an alignment at rest: derivative of the attitude error at the start by errors of rate and force in east-north-up axes, [d phi / d
/// rate, d phi / d force].
Eigen::Matrix<double, 3, 6> alignment_effect(const NavigationState& start, const StartErrors& errors, const StrapdownOptions& options);

}  // namespace imulab::budget
