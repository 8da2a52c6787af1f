// Sensitivities to every error source, and the covariance due to noise, along a motion.
#pragma once

#include "imulab/navigation/budget/budget.hpp"
#include "imulab/navigation/budget/error_dynamics.hpp"
#include "imulab/navigation/budget/source_effects.hpp"

#include <optional>
#include <string>
#include <vector>

namespace imulab::budget {

/// First columns of the sensitivities: coefficients; a unit error of each gyro and accelerometer after compensation (turn-on); an error that grows by
/// one per second; position, velocity and attitude at the start; bias of the barometer.
struct SourceColumns {
  Eigen::Index coefficients, gyro_unit = coefficients, accel_unit = gyro_unit + 3, gyro_ramp = accel_unit + 3, accel_ramp = gyro_ramp + 3,
                             start = accel_ramp + 3, barometer = start + 9, count = barometer + 1;
};

struct NoiseSource {
  enum class Acts { gyro_white, accel_white, gyro, accel, barometer } acts;
  std::string name;
  NoiseGrowth growth;
  double quantization = 0;  // Q, for quantization noise
};

/// The output times: the first sample at or after each multiple of `interval` [s] from the start.
class Outputs {
 public:
  /// Throws Error unless the interval is above 0.
  Outputs(double begin, double interval);
  /// Returns true if an output is due at the next sample.
  bool due(double time);

 private:
  double begin_, interval_, next_;
};

/// Follows a motion sample by sample. Sensor errors are summed over a block of samples and act at its middle.
class ErrorGrowth {
 public:
  /// Throws Error like GrowingBudget.
  ErrorGrowth(double begin, double interval, const NavigationState& start, const ErrorSources& sources, const BudgetOptions& options);
  /// Starts at the start of this motion.
  ErrorGrowth(const motion::NominalMotion& motion, const ErrorSources& sources, const BudgetOptions& options);

  /// Adds a sample; returns true if an output is due here, and the block has ended. Throws Error unless the time is after the previous one.
  bool add(double time, const NavigationState& state, const Increment& sample);
  /// Ends the last block; returns true if it has a new output. Throws Error if there was no sample.
  bool finish();
  double time() const { return block_.time.back(); }

  const SourceColumns& columns() const { return columns_; }
  /// Returns the derivatives of the present error state by each source, including the effect through an alignment.
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
  motion::NominalMotion block_;  // not yet ended
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

/// Returns a budget's name for the kind of a coefficient: "gyro misalignment".
std::string group_of(const Coefficient& c);

/// Throws Error for a motion without samples, with parts of inconsistent sizes, or with times that do not ascend.
void check(const motion::NominalMotion& motion);

/// Returns the derivatives of the error state at the end by each source.
ErrorColumns error_sensitivities(const motion::NominalMotion& motion, const ErrorSources& sources, const BudgetOptions& options = {});

/// Returns the samples with outputs: the first at or after each multiple of `interval` [s] from the start, and the last.
std::vector<std::size_t> output_samples(const motion::NominalMotion& motion, double interval);

/// Returns the effect of an alignment at rest: derivatives of the attitude error at the start by errors of rate and force in east-north-up axes, [d
/// phi / d rate, d phi / d force].
Eigen::Matrix<double, 3, 6> alignment_effect(const NavigationState& start, const StartErrors& errors, const StrapdownOptions& options);

}  // namespace imulab::budget
