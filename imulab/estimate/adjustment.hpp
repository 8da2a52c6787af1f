// Least squares with conditions (Gauss-Helmert): each condition w(theta, observations) = 0 would hold for perfect data, and the observations' noise
// reaches it with a known covariance that couples neighbouring blocks only. To first order this is maximum likelihood, with the true
// attitudes of the rests eliminated.
#pragma once

#include <Eigen/Core>

#include <array>
#include <vector>

namespace imulab {

/// What a condition compares; each kind may show more spread than the sample noise explains.
enum class ConditionKind { gravity, gyro_rest, rotation, prior };
inline constexpr int spread_kinds = 3;  ///< all but prior
using Spreads = std::array<double, spread_kinds>;  ///< additional standard deviation by kind: m/s^2, rad/s, rad

struct Conditions {
  /// Rows first .. first + size - 1; `covariance` of them, `coupling` with the rows of the block before (empty for none).
  struct Block {
    Eigen::Index first = 0, size = 0;
    Eigen::MatrixXd covariance, coupling;
  };
  Eigen::VectorXd value;             ///< w at the current parameters
  Eigen::MatrixXd jacobian;          ///< dw / dtheta
  Eigen::VectorXd variance;          ///< of each row: the diagonal of the blocks
  Eigen::VectorXd spread_gain;       ///< d variance / d spread^2 of the row's own kind
  std::vector<ConditionKind> kind;   ///< by row
  std::vector<Block> blocks;
};

struct Adjustment {
  Eigen::VectorXd correction;         ///< of theta; zero where undetermined
  Eigen::MatrixXd covariance;         ///< of theta; includes what the undetermined parameters' prior sigmas do to the others
  std::vector<char> determined;       ///< by parameter
  Eigen::VectorXd residual;           ///< w after the correction
  Eigen::VectorXd residual_variance;  ///< expected, by row: S - J P J^T
  double chi2 = 0;
  int degrees_of_freedom = 0;
  double condition = 0;               ///< of the normal equations scaled to unit diagonal
};

/// `prior_sigma`: how far each parameter may be from its starting value. A parameter is determined if the data bring its standard deviation
/// below half of that; the others keep their values, and so do those in `excluded` (by parameter; empty for none).
Adjustment adjust(const Conditions& conditions, const Eigen::VectorXd& prior_sigma, const std::vector<char>& excluded = {});

/// The additional spread of a kind with which its residuals have their expected size: zero if the sample noise explains them (1 % level).
double estimate_spread(const Conditions& conditions, const Adjustment& adjustment, ConditionKind kind, double current);

/// Natural logarithm of the probability that leaving out these rows lowers chi-square by as much as it does by chance.
double outlier_log_probability(const Conditions& conditions, const Adjustment& adjustment, const std::vector<Eigen::Index>& rows);

/// Chi-square and expected value of the residuals of one kind, for reporting.
struct KindFit {
  double chi2_per_dof = 0, degrees_of_freedom = 0, rms = 0;
};
KindFit fit_of(const Conditions& conditions, const Adjustment& adjustment, ConditionKind kind);

}  // namespace imulab
