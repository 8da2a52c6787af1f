// The terms that a calibration on a turntable estimates, and their priors. A prediction uses the same.
#pragma once

#include "imulab/estimate/turntable/estimator.hpp"
#include "imulab/recording/session.hpp"

#include <string_view>
#include <vector>

namespace imulab::turntable {

/// `wanted` as CalibrationOptions::terms; empty: offsets, matrices and g-sensitivity. The forward model keeps a matrix whole or diagonal, and the
/// other terms whole. Throws TermsError.
std::vector<CoefficientIndex> chosen_coefficients(const std::vector<CoefficientIndex>& wanted, std::string_view accel_unit,
                                                  std::string_view gyro_unit);

/// The options with every term that an IMU may have, under its prior: as it is declared, or with the offsets that the IMU shows [m/s^2, rad/s].
EstimatorOptions with_optional_terms(EstimatorOptions options, const ImuDeclaration& imu, const Vector3d& accel_offset, const Vector3d& gyro_offset);

}  // namespace imulab::turntable
