// Priors of the terms that an IMU may or may not have. A term that the data cannot exclude counts, whether they show it or not: it is estimated under
// its prior, or considered.
#pragma once

#include "imulab/core/rotation.hpp"
#include "imulab/estimate/kernel/prior.hpp"
#include "imulab/recording/session.hpp"

#include <string>
#include <vector>

namespace imulab::kernel {

/// Priors of quadratic, cubic, g-sensitivity and lever arms for any method, in fields of the same name; offsets, scales, misalignments and drifts
/// stay 0. Declared sizes come first, then those of the declared grade, then sizes that grow with the offsets, `accel_offset` [m/s^2] and
/// `gyro_offset` [rad/s]: a sensor whose zero is far off is not straight either (docs/priors.md).
PriorSizes optional_priors(const ImuDeclaration& imu, const Vector3d& accel_offset, const Vector3d& gyro_offset);

/// By how much a prior about zero is to be widened that the data contradict: estimates under it, with their covariance, are as large as chance makes
/// them less than once in a thousand. Twice their size over what is expected of it, so that the prior pulls neither them nor others. Else 1.
double widening(const Eigen::VectorXd& value, const Eigen::VectorXd& prior_sigma, const Eigen::MatrixXd& covariance);

/// Widens those of `sizes` that these estimates contradict, term by term; their names. Other coefficients among `indices` do not count.
std::vector<std::string> widen_priors(PriorSizes& sizes, const std::vector<CoefficientIndex>& indices, const Eigen::VectorXd& value,
                                      const Eigen::VectorXd& prior_sigma, const Eigen::MatrixXd& covariance);

}  // namespace imulab::kernel
