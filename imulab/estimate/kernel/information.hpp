// Least squares for all methods: parameters with priors, normal equations of the data, and their solution.
#pragma once

#include "imulab/eigen.hpp"

#include <limits>
#include <string_view>
#include <vector>

namespace imulab::kernel {

/// The role of a parameter in a fit.
enum class Role : char {
  estimated,   ///< estimated from the data and its prior, if it has one
  considered,  ///< keeps its prior value; its prior sigma enters the covariance of the others
  fixed,       ///< keeps its prior value, which counts as exact
};

/// The prior sigma of a parameter without a prior.
inline constexpr double no_prior = std::numeric_limits<double>::infinity();

/// The unknowns of a fit, in order: coefficients, then nuisances (g, rig errors, Earth's rate).
struct Parameters {
  std::vector<Role> role;
  Eigen::VectorXd offset;  ///< prior value minus present value, in the unit of the parameter
  Eigen::VectorXd sigma;   ///< standard deviation of the prior, or `no_prior` (not for considered parameters)

  Parameters() = default;
  /// All parameters are estimated without a prior.
  explicit Parameters(Eigen::Index size);
  Eigen::Index size() const { return sigma.size(); }
  std::vector<Eigen::Index> with(Role wanted) const;
};

/// Whitened sum of squared residuals, to second order in the correction x of the parameters: chi2 + 2 g.x + x.N x. Additive over the data.
struct Information {
  Eigen::MatrixXd N;
  Eigen::VectorXd g;
  double chi2 = 0;  ///< at x = 0
  int rows = 0;

  Information() = default;
  explicit Information(Eigen::Index parameters);
  /// Sums whitened rows: residuals, and their derivatives with respect to the parameters.
  Information(const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& residual);
  Information& operator+=(const Information& other);
  Information operator-(const Information& other) const;
  double at(const Eigen::VectorXd& x) const { return chi2 + 2 * g.dot(x) + x.dot(N * x); }
};

struct Solution {
  Eigen::VectorXd x;              ///< correction of the parameters
  Eigen::MatrixXd covariance;     ///< covariance of all parameters; zero for fixed ones
  double chi2 = 0;                ///< chi-square of the data at x
  double degrees_of_freedom = 0;  ///< number of rows minus the number of estimated parameters that the data determine
};

/// Returns the correction that minimizes the sum of squares of data and priors. Throws Unsupported with `what` if a parameter is not determined.
Solution solve(const Information& data, const Parameters& parameters, std::string_view what = "the data");

/// Returns the logarithm of the data's probability, averaged over the parameters' priors, up to terms that depend only on the noise and on the number
/// of parameters without a prior.
double log_probability(const Information& data, Parameters parameters, std::string_view what = "the data");

/// Solves from whitened residuals and their derivatives without normal equations, which square the condition number: for data that determine some
/// directions a million times better than others.
Solution solve(const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& residual, const Parameters& parameters, std::string_view what = "the data");

/// Returns the gain of that solution without considered parameters: minus the derivative of the correction by the residuals. Throws like `solve`.
Eigen::MatrixXd gain(const Eigen::MatrixXd& jacobian, const Parameters& parameters, std::string_view what = "the data");

/// Returns only the correction of `solve`, in a fraction of the time. Considered parameters have their prior value.
Eigen::VectorXd correction(const Information& data, Parameters parameters, std::string_view what = "the data");

/// Removes the parameters with role `considered` from an estimate that was made with them under their priors. They return to their prior value, and
/// their prior sigma enters the covariance of the others ("consider covariance"):
///   G = P_ec P_cc^-1,  x_e += G (offset_c - x_c),  P_ee += G (S_c - P_cc) G^T,  P_ec = G S_c
void consider(Eigen::VectorXd& x, Eigen::MatrixXd& covariance, const Parameters& parameters);

/// Returns estimated parameters whose standard deviation is not below `needed`: the data do not determine them.
std::vector<Eigen::Index> undetermined(const Eigen::MatrixXd& covariance, const Parameters& parameters, const Eigen::VectorXd& needed);

/// Returns the square root of the ratio of largest to smallest eigenvalue of a symmetric matrix scaled to unit diagonal: of a covariance, or of the
/// normal equations of data and priors for the parameters that do not keep their prior value.
double condition_number(const Eigen::MatrixXd& symmetric);
double condition_number(const Information& data, const Parameters& parameters);
double condition_number(const Eigen::MatrixXd& jacobian, const Parameters& parameters);

}  // namespace imulab::kernel
