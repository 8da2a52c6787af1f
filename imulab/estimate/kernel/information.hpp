// Least squares for all methods: parameters with their priors, the normal equations of the data, and the solution.
#pragma once

#include "imulab/eigen.hpp"

#include <limits>
#include <string_view>
#include <vector>

namespace imulab::kernel {

/// The role of a parameter in a fit.
enum class Role : char {
  estimated,   ///< by the data, under its prior where it has one
  considered,  ///< stays at its prior value; its prior sigma counts in the covariance of the others
  fixed,       ///< stays at its prior value, which is taken as exact
};

/// The prior sigma of a parameter without a prior.
inline constexpr double no_prior = std::numeric_limits<double>::infinity();

/// The unknowns of a fit, in order: coefficients, then nuisances (g, errors of a rig, Earth's rate).
struct Parameters {
  std::vector<Role> role;
  Eigen::VectorXd offset;  ///< prior value less the present value, in the parameter's unit
  Eigen::VectorXd sigma;   ///< standard deviation of the prior; `no_prior`: none (not for considered parameters)

  Parameters() = default;
  /// All estimated without a prior.
  explicit Parameters(Eigen::Index size);
  Eigen::Index size() const { return sigma.size(); }
  std::vector<Eigen::Index> with(Role wanted) const;
};

/// A sum of squares of residuals, whitened, to second order in the correction x of the parameters: chi2 + 2 g.x + x.N x. Additive over the data.
struct Information {
  Eigen::MatrixXd N;
  Eigen::VectorXd g;
  double chi2 = 0;  ///< at x = 0
  int rows = 0;

  Information() = default;
  explicit Information(Eigen::Index parameters);
  /// Sums whitened rows: residuals and their derivatives by the parameters.
  Information(const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& residual);
  Information& operator+=(const Information& other);
  Information operator-(const Information& other) const;
  double at(const Eigen::VectorXd& x) const { return chi2 + 2 * g.dot(x) + x.dot(N * x); }
};

struct Solution {
  Eigen::VectorXd x;              ///< correction of the parameters
  Eigen::MatrixXd covariance;     ///< of all parameters; zero for the fixed ones
  double chi2 = 0;                ///< of the data at x
  double degrees_of_freedom = 0;  ///< rows less what the data determine of the estimated parameters
};

/// The correction that minimizes the sum of squares and the priors. Throws Unsupported, naming `what`, where the estimated parameters are not
/// determined.
Solution solve(const Information& data, const Parameters& parameters, std::string_view what = "the data");

/// Logarithm of the data's probability, whatever the parameters are within their priors; but for what depends on the noise alone and on the number of
/// parameters without a prior.
double log_probability(const Information& data, Parameters parameters, std::string_view what = "the data");

/// Solves from whitened residuals and their derivatives, without the normal equations, whose condition number is the square of the derivatives': for
/// data that determine some directions a million times better than others.
Solution solve(const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& residual, const Parameters& parameters, std::string_view what = "the data");

/// The gain of that solution without considered parameters: minus the derivatives of the correction by the residuals. Throws as `solve` does.
Eigen::MatrixXd gain(const Eigen::MatrixXd& jacobian, const Parameters& parameters, std::string_view what = "the data");

/// The correction of `solve` alone, which takes a fraction of the time. The considered parameters are at their prior value.
Eigen::VectorXd correction(const Information& data, Parameters parameters, std::string_view what = "the data");

/// Takes the parameters with role `considered` out of an estimate that was made with them under their priors: they return to their prior value, and
/// their prior sigma counts in the covariance of the others ("consider covariance"):
///   G = P_ec P_cc^-1,  x_e += G (offset_c - x_c),  P_ee += G (S_c - P_cc) G^T,  P_ec = G S_c
void consider(Eigen::VectorXd& x, Eigen::MatrixXd& covariance, const Parameters& parameters);

/// Estimated parameters whose standard deviation is not below `needed`: the data do not determine them.
std::vector<Eigen::Index> undetermined(const Eigen::MatrixXd& covariance, const Parameters& parameters, const Eigen::VectorXd& needed);

/// Square root of the largest over the least eigenvalue of a symmetric matrix scaled to unit diagonal: of a covariance, or of the normal equations of
/// data and priors without the parameters that stay at their prior value.
double condition_number(const Eigen::MatrixXd& symmetric);
double condition_number(const Information& data, const Parameters& parameters);
double condition_number(const Eigen::MatrixXd& jacobian, const Parameters& parameters);

}  // namespace imulab::kernel
