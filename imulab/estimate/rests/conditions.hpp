// Least squares with conditions (Gauss-Helmert): each condition w(theta, observations) = 0 would hold for perfect data, and the observations' noise
// reaches it with a known covariance that couples neighboring blocks only. To first order this is maximum likelihood, with the true attitudes of the
// rests eliminated.
#pragma once

#include "imulab/core/decomposition.hpp"
#include "imulab/eigen.hpp"
#include "imulab/estimate/kernel/fit.hpp"
#include "imulab/estimate/kernel/information.hpp"

#include <array>
#include <vector>

namespace imulab::rests {

/// The quantity that a condition compares; each kind but the last, whose spread is declared, may spread by more than the sample noise explains.
enum class Kind { gravity, gyro_rest, rotation, turn };
inline constexpr int kinds = 3;
using Spreads = std::array<double, kinds>;  ///< additional standard deviation by kind: m/s^2, rad/s, rad

struct Conditions {
  Eigen::VectorXd value;     ///< w at the current parameters
  Eigen::MatrixXd jacobian;  ///< dw / dtheta
  std::vector<Kind> kind;    ///< by row; its variance grows by the square of its kind's spread
  BlockTridiagonal blocks;   ///< covariance of w, a block a rest

  Conditions(Eigen::Index rows, Eigen::Index parameters)
      : value(Eigen::VectorXd::Zero(rows)), jacobian(Eigen::MatrixXd::Zero(rows, parameters)), kind(static_cast<std::size_t>(rows), Kind::gravity) {}
  kernel::Information information() const;
  /// Of the covariance.
  double log_determinant() const;
};

struct Adjustment {
  kernel::Solution solution;
  Eigen::VectorXd residual;           ///< w after the correction
  Eigen::VectorXd variance;           ///< of w, by row
  Eigen::VectorXd residual_variance;  ///< expected of the residuals, by row: S - J P J^T
};
/// Considered parameters are fixed here: their effect on the covariance of the others does not concern the residuals.
Adjustment adjust(const Conditions& conditions, kernel::Parameters parameters);

/// Degrees of freedom that the residuals of one kind keep.
double redundancy(const Conditions& conditions, const Adjustment& adjustment, Kind kind);

/// Does a kind's spread exceed the conditions' covariance at the 1/6 significance level?
bool spread_is_significant(const Conditions& conditions, const Adjustment& adjustment, Kind kind);

/// The additional spread of a kind with which its residuals have their expected size, larger where few degrees of freedom show it; zero where they
/// are smaller without any. `current`: the one that is in the conditions' covariance.
double estimate_spread(const Conditions& conditions, const Adjustment& adjustment, Kind kind, double current);

/// The deviation of rows from the fit of the others.
kernel::Deviation deviation_of(const Conditions& conditions, const Adjustment& adjustment, const std::vector<Eigen::Index>& rows);

}  // namespace imulab::rests
