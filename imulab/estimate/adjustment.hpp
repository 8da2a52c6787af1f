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
  Eigen::VectorXd correction;         ///< of theta
  Eigen::MatrixXd covariance;         ///< of theta, priors included
  std::vector<char> determined;       ///< by parameter: the data bring its standard deviation below half of its prior's
  Eigen::VectorXd residual;           ///< w after the correction
  Eigen::VectorXd residual_variance;  ///< expected, by row: S - J P J^T
  double chi2 = 0;                    ///< of all but the priors
  double degrees_of_freedom = 0;      ///< its expected value
  double condition = 0;               ///< of the normal equations scaled to unit diagonal
};

/// Every parameter has a prior condition among the rows, so the normal equations are regular whatever the data leave open, and covariance, residuals and
/// chi-square count what is not known. `prior_sigma` are the priors' standard deviations, as the measure of what the data determine.
Adjustment adjust(const Conditions& conditions, const Eigen::VectorXd& prior_sigma);

/// Degrees of freedom that the residuals of one kind keep.
double redundancy(const Conditions& conditions, const Adjustment& adjustment, ConditionKind kind);

/// Does a kind's spread exceed what the conditions' covariance explains (1 % level)?
bool spread_is_significant(const Conditions& conditions, const Adjustment& adjustment, ConditionKind kind);

/// The additional spread of a kind with which its residuals have their expected size; zero where they are smaller without any.
double estimate_spread(const Conditions& conditions, const Adjustment& adjustment, ConditionKind kind, double current);

/// How far off rows are: the chi-square that leaving them out saves, and its degrees of freedom.
struct Deviation {
  double statistic = 0, degrees_of_freedom = 0;
  /// Natural logarithm of the probability that chance does as much.
  double log_probability() const;
  /// The same where the size of the residuals was itself estimated from `residual_degrees` degrees of freedom (F distribution).
  double log_probability(double residual_degrees) const;
};
Deviation deviation_of(const Conditions& conditions, const Adjustment& adjustment, const std::vector<Eigen::Index>& rows);

}  // namespace imulab
