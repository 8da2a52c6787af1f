// Least squares with conditions (Gauss-Helmert). Perfect data satisfy each condition w(theta, observations) = 0. The observations' noise gives w a
// known covariance that couples neighboring blocks only. To first order this is maximum likelihood with the true attitudes of the rests eliminated.
#pragma once

#include "imulab/core/decomposition.hpp"
#include "imulab/eigen.hpp"
#include "imulab/estimate/kernel/fit.hpp"
#include "imulab/estimate/kernel/information.hpp"

#include <array>
#include <vector>

namespace imulab::rests {

/// The compared quantity of a condition. Each kind except the last, whose spread is declared, may spread by more than the sample noise.
enum class Kind { gravity, gyro_rest, rotation, turn };
inline constexpr int kinds = 3;
using Spreads = std::array<double, kinds>;  ///< additional standard deviation of each kind: m/s^2, rad/s, rad

struct Conditions {
  Eigen::VectorXd value;     ///< w at the current parameters
  Eigen::MatrixXd jacobian;  ///< dw / dtheta
  std::vector<Kind> kind;    ///< kind of each row; the variance of a row grows by the square of its kind's spread
  BlockTridiagonal blocks;   ///< covariance of w, one block per rest

  Conditions(Eigen::Index rows, Eigen::Index parameters)
      : value(Eigen::VectorXd::Zero(rows)), jacobian(Eigen::MatrixXd::Zero(rows, parameters)), kind(static_cast<std::size_t>(rows), Kind::gravity) {}
  kernel::Information information() const;
  /// Returns the log determinant of the covariance.
  double log_determinant() const;
};

struct Adjustment {
  kernel::Solution solution;
  Eigen::VectorXd residual;           ///< w after the correction
  Eigen::VectorXd variance;           ///< variance of w, by row
  Eigen::VectorXd residual_variance;  ///< expected variance of the residuals, by row: S - J P J^T
};
/// Solves the conditions. Considered parameters count as fixed: their effect on the covariance of the others does not concern the residuals.
Adjustment adjust(const Conditions& conditions, kernel::Parameters parameters);

/// Returns the degrees of freedom that remain in the residuals of one kind.
double redundancy(const Conditions& conditions, const Adjustment& adjustment, Kind kind);

/// Returns true if a kind's spread is significant at the level 1/6.
bool spread_is_significant(const Conditions& conditions, const Adjustment& adjustment, Kind kind);

/// Returns the additional spread of a kind that gives its residuals their expected size, enlarged for few degrees of freedom; zero if no spread is
/// needed. `current`: the spread that the conditions' covariance contains.
double estimate_spread(const Conditions& conditions, const Adjustment& adjustment, Kind kind, double current);

/// Returns the deviation of `rows` from the fit of the other rows.
kernel::Deviation deviation_of(const Conditions& conditions, const Adjustment& adjustment, const std::vector<Eigen::Index>& rows);

}  // namespace imulab::rests
