// The gyro integral of the rotation between two rests, with its derivatives.
#pragma once

#include "imulab/model/effects.hpp"
#include "imulab/recording/scaling.hpp"

#include <array>
#include <cstddef>
#include <functional>
#include <vector>

namespace imulab {

/// The rotation from a range of gyro samples with its derivatives. `C` transforms body axes at the end to those at the beginning: C = prod exp(w dt),
/// with rates as means over their intervals, and coning from each interval and the previous one. `phi` are first-order integrals of C(t) b(t) dt for
/// b = 1, gyro x, y, z, force x, y, z, and for the diagonal matrices b = gyro^2, gyro^3: a rate error dW0 + dW1 V + dC f + dW2 V^2 + dW3 V^3 changes
/// C to (I + [dphi x]) C with dphi = phi[0] dW0 + sum_j phi[1 + j] dW1.col(j) + sum_j phi[4 + j] dC.col(j) + phi[7] dW2 + phi[8] dW3.
struct IntegratedRotation {
  Matrix3d C;
  std::array<Matrix3d, 9> phi;
  Eigen::Matrix3Xd by_effect;  ///< dphi for each column of the effects: a rate error c phi
  Eigen::VectorXd effects;     ///< the values c that C is without
  Matrix3d covariance;         ///< covariance of dphi due to sample noise of the gyros, rad^2
  Vector3d reading;            ///< integral of the scaled gyro readings
  double duration_s;

  /// Returns dphi from one gyro model to another.
  Vector3d change(const TriadModel& from, const Matrix3d& from_g, const TriadModel& to, const Matrix3d& to_g) const;
};

/// Columns of effects on the gyros, and the state at a sample without its force and rate.
struct RateEffects {
  std::vector<EffectColumn> columns = {};
  Eigen::VectorXd values = {};  ///< known values, which C is to be without; empty: none
  std::function<EffectState(std::size_t)> state = {};
};

/// Integrates the samples of `range`, which must not contain a gap. The model applies to scaled readings and has no thermal terms.
IntegratedRotation integrate_rotation(const Recording& recording, Range range, const SensorModel& scaled_model, const Scaling& scaling,
                                      const Vector3d& gyro_sigma_scaled, const RateEffects& effects = {});

}  // namespace imulab
