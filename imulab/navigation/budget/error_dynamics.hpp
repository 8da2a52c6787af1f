// Linear error dynamics of strapdown integration: growth of errors of attitude, velocity and position along a motion, in east-north-up axes (Xu 2024,
// doi:10.20096/j.xhxb.1008-9233.2024.01.001, eqs 1 to 5; Savage 1998; Groves 2013).
//
//   phi'   = -w_in x phi + dw_in - C_nb dw                                             (1)
//   dv'    = f_n x phi - (2 w_ie + w_en) x dv - (2 dw_ie + dw_en) x v + C_nb df + dg   (2), with gravity's change dg
//   dL'    = dvN / (RM + h) - vN dh / (RM + h)^2                                       (3)
//   dlon'  = sec L (dvE + vE tan L dL - vE dh / (RN + h)) / (RN + h)                   (4)
//   dh'    = dvU                                                                       (5)
//
// Valid to first order: 1 deg of attitude error leaves up to 1 % of its effect; position errors must be small compared with the radii, and latitudes
// within 89.9 deg. For example, a gyro bias of 1 deg/h for 100 s at rest is |phi| = 4.8e-4 rad: it tilts gravity by 0.0048 m/s^2.
#pragma once

#include "imulab/eigen.hpp"
#include "imulab/navigate.hpp"

namespace imulab::budget {

/// Indices of errors (computed minus true, east-north-up): attitude phi [rad] (C_hat = (I - [phi x]) C_nb), velocity [m/s], position [m] (dlon (RN+h)
/// cos L, dL (RM+h), dh), and the integral of the barometer loop [m/s^2].
struct ErrorIndex {
  static constexpr int attitude = 0, velocity = 3, position = 6, up = 8, barometer = 9, count = 10;
};
using ErrorState = Eigen::Matrix<double, ErrorIndex::count, 1>;
using ErrorMatrix = Eigen::Matrix<double, ErrorIndex::count, ErrorIndex::count>;
using ErrorColumns = Eigen::Matrix<double, ErrorIndex::count, Eigen::Dynamic>;

/// Convert between states and errors; the element of the barometer is not part of a state.
ErrorState error_of(const NavigationState& computed, const NavigationState& truth);
NavigationState with_error(const NavigationState& truth, const ErrorState& error);

/// F and b in x' = F x + b (barometer error [m]) + contribution of the sensors: -C_nb dw to the attitude, C_nb df to the velocity.
struct ErrorDynamics {
  ErrorMatrix F;
  ErrorState b;
};
/// Returns the dynamics at a state; `force_n` is the specific force in east-north-up axes [m/s^2].
ErrorDynamics error_dynamics(const NavigationState& state, const Eigen::Vector3d& force_n, const StrapdownOptions& options);

/// Returns exp(F T) for an interval T [s].
ErrorMatrix error_transition(const ErrorMatrix& F, double interval);

}  // namespace imulab::budget
