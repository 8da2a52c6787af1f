// The covariance of the error state from a sensor's noise.
#pragma once

#include "imulab/model/flicker.hpp"
#include "imulab/navigation/budget/error_dynamics.hpp"

#include <Eigen/Core>

namespace imulab::budget {

/// First-order processes z' = -pole z + gain u, driven by one white noise u of unit density; the output is their sum and `direct` u.
struct NoiseProcesses {
  Eigen::VectorXd pole, gain;
  double direct = 0;
  bool stationary = true;  // at the start; else zero
};
NoiseProcesses white_noise(double density);
NoiseProcesses random_walk(double K);
NoiseProcesses flicker_noise(double B, double interval);
NoiseProcesses markov_noise(double sigma, double time_constant);

/// Independent, equal noises that act through the columns of an effect.
class NoiseGrowth {
 public:
  NoiseGrowth() = default;
  NoiseGrowth(NoiseProcesses processes, int noises);

  /// `effect`: what a noise that is constant at one throughout the interval adds to the error state by its end. The moments of the processes over
  /// the interval are exact; their mean acts.
  void step(const ErrorMatrix& transition, const ErrorColumns& effect, double interval);

  /// The covariance at the start.
  void add(const ErrorMatrix& covariance) { covariance_ += covariance; }

  const ErrorMatrix& covariance() const { return covariance_; }
  /// Of the error state and the sum of a noise's processes, and of that sum.
  ErrorState with_noise(int noise) const { return cross_[static_cast<std::size_t>(noise)].rowwise().sum(); }
  double noise_variance() const { return own_.sum(); }

 private:
  void prepare(double interval);

  NoiseProcesses processes_;
  ErrorMatrix covariance_ = ErrorMatrix::Zero();
  std::vector<ErrorColumns> cross_;  // of the error state and each noise's processes
  Eigen::MatrixXd own_;              // of one noise's processes

  // Over an interval: decay, and what a process gives the integral by its start; second moments of what is new.
  double interval_ = 0;
  Eigen::VectorXd decay_, integral_, new_with_integral_;
  Eigen::MatrixXd new_;
  double new_integral_ = 0;
};

}  // namespace imulab::budget
