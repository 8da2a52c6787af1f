// Effect sizes, inferred together with the effects. A fixed prior size is wrong in both directions: an IMU is better or worse than its class, and the
// data determine by how much. The effects have the values c_k ~ N(0, (lambda t o_k s_k)^2), with
//
//   s_k     the size that the table has for the grade, or a declared one, which has no factors
//   lambda  a factor of the whole IMU, ln lambda ~ N(0, ln^2 5); it does not apply to the rig, the site, or the mount
//   t, o_k  factors of a triad and of the effect, ln ~ N(0, ln^2 2)
//
// A method supplies the information of its data about c after elimination of all other parameters, ln p(r | c) = -1/2 c.L c + eta.c. For each lambda
// of a grid, the most probable t and o_k are computed. The sizes are root mean squares over the grid and, if no grade is declared, over the grades.
// Priors of these sizes give the result of the mixture (to 1 % in the linear test problem). The mean square excludes lambda above 4 unless the data
// make it more probable: an IMU is assumed to belong to its class. This requires no pass over the samples.
#pragma once

#include "imulab/eigen.hpp"

#include <string>
#include <vector>

namespace imulab::kernel {

/// The columns of one effect, which share one size.
struct SizedGroup {
  enum class Of {
    declared,  ///< the size is known and has no factors
    rig,       ///< rig, site, mount or optional term: only its own factor
    unit,      ///< effect of both triads: its own factor and the factor of the IMU
    accel,     ///< additionally the factor of its triad
    gyro,
  };
  Eigen::Index first = 0, size = 0;
  Of of = Of::unit;
};

/// Sizes of the groups under one hypothesis: one sigma, SI.
struct SizeHypothesis {
  std::string grade;               ///< empty: the declared one
  double log_weight = 0;           ///< logarithm of its probability, up to a constant, without evidence from the effects
  std::vector<double> sizes = {};  ///< one size per group
};

/// Information of the data about the effects: -2 ln p(r | c) = c.L c - 2 eta.c + constant.
struct ReducedEffects {
  Eigen::MatrixXd L;
  Eigen::VectorXd eta;
};

/// One lambda of one hypothesis.
struct SizeNode {
  std::size_t hypothesis = 0;
  double log_factor = 0;  ///< ln lambda
  double weight = 0;      ///< probability; the sum over all nodes is 1
  /// For each group, logarithms of the factors in its size, all together and its own alone, with their variances.
  std::vector<double> log_all = {}, all_variance = {}, log_own = {}, own_variance = {};
};

struct SizePosterior {
  std::vector<double> rms;           ///< root mean square size of each group, SI
  double log_factor = 0, sigma = 0;  ///< mean and standard deviation of ln lambda
  std::vector<double> weights;       ///< weights of the hypotheses; their sum is 1
  std::vector<SizeNode> nodes;
  double log_evidence = 0;  ///< logarithm of p(r) / p(r | c = 0), averaged over the sizes, up to a constant

  /// Returns the probability that the product of a group's factors exceeds `factor`.
  double exceeds(std::size_t group, double factor) const;
  /// Returns the probability that a group's own factor exceeds `factor`, so that it stands out of its IMU.
  double stands_out(std::size_t group, double factor) const;
  /// Returns the probability that lambda exceeds `factor`.
  double factor_exceeds(double factor) const;
};

/// Returns the logarithm of p(r | sizes), up to a constant; `size` has one element per column.
double log_evidence(const ReducedEffects& data, const Eigen::VectorXd& size);
/// Returns eta^T (L + S^-1)^-1 eta, the reduction of the minimum cost of data and priors by effects of these sizes.
double explained_cost(const ReducedEffects& data, const Eigen::VectorXd& size);

/// Infers the sizes. Every group must have a size above 0 in every hypothesis.
SizePosterior infer_sizes(const ReducedEffects& data, const std::vector<SizedGroup>& groups, const std::vector<SizeHypothesis>& hypotheses);

}  // namespace imulab::kernel
