// The effect of the sources of error on the inputs of the error dynamics, C_nb dw and C_nb df of Xu 2024's eqs 1 and 2: coefficients, integrated in
// east-north-up axes, and noise.
#pragma once

#include "imulab/coefficient.hpp"
#include "imulab/compensate.hpp"
#include "imulab/eigen.hpp"
#include "imulab/model/sensor_noise.hpp"
#include "imulab/navigation/budget/error_dynamics.hpp"

#include <array>
#include <vector>

namespace imulab::budget {

/// Sums over samples of interval x C_nb x derivative of the compensated rate and force by each coefficient, at the raw readings that compensate to
/// the true motion. An error of an accelerometer's coefficient acts on the rate through the g-sensitivity, as in `compensate`.
class CoefficientEffects {
 public:
  /// Throws Error for a lever arm among the coefficients: `compensate` does not know it.
  CoefficientEffects(const SensorModel& model, const std::vector<CoefficientIndex>& coefficients, const Vector3d& accel_tau = Vector3d::Zero(),
                     const Vector3d& gyro_tau = Vector3d::Zero());

  void add(const Matrix3d& C_nb, const Motion& motion, double interval);
  void clear();

  const Eigen::Matrix3Xd& rate() const { return rate_; }    // rad by unit of each coefficient
  const Eigen::Matrix3Xd& force() const { return force_; }  // m/s

 private:
  /// A derivative is a scalar of the sample times a direction fixed in the body.
  struct Effect {
    Eigen::Index coefficient, scalar, direction;
  };

  SensorModel model_;
  bool plain_;  // the ideal unit: raw readings are the motion
  Vector3d accel_tau_, gyro_tau_;
  std::vector<Effect> rate_effects_, force_effects_;
  Eigen::Matrix3Xd rate_, force_;
};

// The covariance of the error state from a sensor's noise.

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
  /// Covariance of the error state with the sum of a noise's processes, and variance of this sum.
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
