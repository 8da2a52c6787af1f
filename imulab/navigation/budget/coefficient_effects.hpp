// The effect of errors of the sensor model's coefficients on the compensated output, in east-north-up axes and integrated.
#pragma once

#include "imulab/model/coefficient.hpp"
#include "imulab/model/compensate.hpp"

#include <Eigen/Core>

#include <array>
#include <vector>

namespace imulab::budget {

/// Sums over samples of interval x C_nb x derivative of the compensated rate and force to each coefficient, at the raw readings that compensate to
/// the true motion. An error of an accelerometer's
/// coefficient acts on the rate through the g-sensitivity, as in `compensate`.
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

}  // namespace imulab::budget
