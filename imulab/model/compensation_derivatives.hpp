// Derivatives of a calibrated sample by the coefficients, the raw readings and the thermal readings. With a covariance of the coefficients they give
// the uncertainty of the compensated output.
#pragma once

#include "imulab/model/calibration.hpp"
#include "imulab/model/compensate.hpp"

#include <Eigen/Core>

namespace imulab {

/// Rows of every matrix: force x y z [m/s^2], rate x y z [rad/s].
struct CompensationDerivatives {
  Motion motion;                                             ///< compensate(model, raw)
  Eigen::Matrix<double, 6, coefficient_count> coefficients;  ///< by table index; lever arms do not act on a sample alone
  Eigen::Matrix<double, 6, 6> raw;                           ///< accel x y z, gyro x y z
  Eigen::Matrix<double, 6, 6> temperature;                   ///< accel tau x y z, gyro tau x y z
};
CompensationDerivatives compensation_derivatives(const SensorModel& model, const RawSample& raw);

/// Covariance of a compensated sample from that of the estimated coefficients alone (not from the sample's own noise).
Eigen::Matrix<double, 6, 6> output_covariance(const Calibration& calibration, const RawSample& raw);

}  // namespace imulab
