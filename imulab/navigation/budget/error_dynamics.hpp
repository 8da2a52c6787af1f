// Linear error dynamics of strapdown integration: how an error of attitude, velocity and position grows along a motion (Savage 1998; Groves 2013, in
// east-north-up axes).
#pragma once

#include "imulab/navigation/integration/strapdown.hpp"

#include <Eigen/Core>

namespace imulab::budget {

/// Computed less true, east-north-up: attitude phi [rad] (C_hat = (I - [phi x]) C_nb), velocity [m/s], position [m] (dlon (RN+h) cos L, dL (RM+h),
/// dh), and the integral of the barometer loop [m/s^2].
struct ErrorIndex {
  static constexpr int attitude = 0, velocity = 3, position = 6, up = 8, barometer = 9, count = 10;
};
using ErrorState = Eigen::Matrix<double, ErrorIndex::count, 1>;
using ErrorMatrix = Eigen::Matrix<double, ErrorIndex::count, ErrorIndex::count>;
using ErrorColumns = Eigen::Matrix<double, ErrorIndex::count, Eigen::Dynamic>;

/// The error of a computed state, and a state with an error (the barometer's entry is not part of a state).
ErrorState error_of(const NavigationState& computed, const NavigationState& truth);
NavigationState with_error(const NavigationState& truth, const ErrorState& error);

/// F and b of x' = F x + b (error of the barometer [m]) + what the sensors add: -C_nb dw in the attitude, C_nb df in the velocity.
struct ErrorDynamics {
  ErrorMatrix F;
  ErrorState b;
};
/// `force_n`: specific force in east-north-up axes [m/s^2].
ErrorDynamics error_dynamics(const NavigationState& state, const Eigen::Vector3d& force_n, const StrapdownOptions& options);

/// exp(F T).
ErrorMatrix error_transition(const ErrorMatrix& F, double interval);

}  // namespace imulab::budget
