// Sensitivities to every source of error, and the covariance that noise leaves, along a motion.
#pragma once

#include "imulab/analysis/error_sources.hpp"
#include "imulab/analysis/noise_growth.hpp"
#include "imulab/navigation/coefficient_effects.hpp"
#include "imulab/navigation/error_dynamics.hpp"

#include <optional>
#include <string>
#include <vector>

namespace imulab {

using ErrorColumns = Eigen::Matrix<double, ErrorIndex::count, Eigen::Dynamic>;

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
  double quantisation = 0;  // Q, where it is that
};

/// Advances by blocks of samples, over each of which the sensors' errors are summed and act in its middle. `motion` must outlive it.
class ErrorGrowth {
 public:
  /// Throws Error for sources or a start that cannot be followed.
  ErrorGrowth(const NominalMotion& motion, const ErrorSources& sources, const StrapdownOptions& options);

  /// On from sample `begin` to sample `end`.
  void block(std::size_t begin, std::size_t end);

  const SourceColumns& columns() const { return columns_; }
  /// Error state by source, now. With an alignment, that which its sources cause through it is in their columns.
  ErrorColumns sensitivities() const;
  std::size_t noises() const { return noises_.size(); }
  const std::string& noise_name(std::size_t i) const { return noises_[i].name; }
  ErrorMatrix noise_covariance(std::size_t i) const;

 private:
  void start();
  void align(double duration);
  void quantise(NoiseSource& noise, std::optional<double> aligned);
  void add_unit(const ErrorColumns& gyro, const ErrorColumns& accel, double time);

  const NominalMotion& motion_;
  StrapdownOptions options_;
  CoefficientEffects effects_;
  SourceColumns columns_;
  ErrorColumns sensitivity_;
  std::vector<NoiseSource> noises_;
  double aligned_ = 0;  // s before the motion
};

/// Numbers of the samples at which a result is given: the first at or after each multiple of `interval` [s] from the start, and the last.
std::vector<std::size_t> output_samples(const NominalMotion& motion, double interval);

/// Of an alignment at rest: start attitude error by errors of rate and force in east-north-up axes, [d phi / d rate, d phi / d force].
Eigen::Matrix<double, 3, 6> alignment_effect(const NavigationState& start, const StrapdownOptions& options);

}  // namespace imulab
