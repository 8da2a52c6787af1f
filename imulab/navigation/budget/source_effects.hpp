// The inputs of the error dynamics, C_nb dw and C_nb df of Xu 2024's eqs 1 and 2: coefficients, integrated in east-north-up axes, and noise.
#pragma once

#include "imulab/coefficient.hpp"
#include "imulab/compensate.hpp"
#include "imulab/eigen.hpp"
#include "imulab/model/sensor_noise.hpp"
#include "imulab/navigation/budget/error_dynamics.hpp"

#include <array>
#include <vector>

namespace imulab::budget {

/// Sums over samples of interval x C_nb x derivative of the compensated rate and force by each coefficient, at the raw readings for the true motion.
/// An error of an accelerometer coefficient also acts on the rate through the g-sensitivity, as in `compensate`.
class CoefficientEffects {
 public:
  /// Throws Error for a lever arm among the coefficients, because `compensate` does not use it.
  CoefficientEffects(const SensorModel& model, const std::vector<CoefficientIndex>& coefficients, const Vector3d& accel_tau = Vector3d::Zero(),
                     const Vector3d& gyro_tau = Vector3d::Zero());

  void add(const Matrix3d& C_nb, const Motion& motion, double interval);
  void clear();

  const Eigen::Matrix3Xd& rate() const { return rate_; }    // rad per unit of each coefficient
  const Eigen::Matrix3Xd& force() const { return force_; }  // m/s

 private:
  /// A derivative is the product of a scalar of the sample and a direction fixed in the body.
  struct Effect {
    Eigen::Index coefficient, scalar, direction;
  };

  SensorModel model_;
  bool plain_;  // ideal unit: raw readings are the motion
  Vector3d accel_tau_, gyro_tau_;
  std::vector<Effect> rate_effects_, force_effects_;
  Eigen::Matrix3Xd rate_, force_;
};

// The covariance of the error state due to sensor noise.

/// First-order processes z' = -pole z + gain u, driven by one white noise u of unit density; the output is their sum plus `direct` u.
struct NoiseProcesses {
  Eigen::VectorXd pole, gain;
  double direct = 0;
  bool stationary = true;  // initially stationary; otherwise zero
};
NoiseProcesses white_noise(double density);
NoiseProcesses random_walk(double K);
NoiseProcesses flicker_noise(double B, double interval);
NoiseProcesses markov_noise(double sigma, double time_constant);

/// Independent noises of equal size that act through the columns of an effect.
class NoiseGrowth {
 public:
  NoiseGrowth() = default;
  NoiseGrowth(NoiseProcesses processes, int noises);

  /// Advances by an interval. `effect` is the change of the error state at its end due to a noise that is constant at one in the interval. The
  /// moments of the processes over the interval are exact; their mean acts.
  void step(const ErrorMatrix& transition, const ErrorColumns& effect, double interval);

  /// Adds a covariance at the start.
  void add(const ErrorMatrix& covariance) { covariance_ += covariance; }

  const ErrorMatrix& covariance() const { return covariance_; }
  /// Return the covariance of the error state with the sum of a noise's processes, and the variance of this sum.
  ErrorState with_noise(int noise) const { return cross_[static_cast<std::size_t>(noise)].rowwise().sum(); }
  double noise_variance() const { return own_.sum(); }

 private:
  void prepare(double interval);

  NoiseProcesses processes_;
  ErrorMatrix covariance_ = ErrorMatrix::Zero();
  std::vector<ErrorColumns> cross_;  // covariance of the error state and the processes of each noise
  Eigen::MatrixXd own_;              // covariance of the processes of one noise

  // For an interval: decay, contribution of a process's start to the integral, and second moments of the new parts.
  double interval_ = 0;
  Eigen::VectorXd decay_, integral_, new_with_integral_;
  Eigen::MatrixXd new_;
  double new_integral_ = 0;
};

}  // namespace imulab::budget
