// The sizes of effects, inferred with the effects. A fixed prior size is wrong in both directions: an IMU is better or worse than its class, and the
// data show by how much. The effects' values are c_k ~ N(0, (lambda t o_k s_k)^2), with
//
//   s_k     the size that the table has for the grade, or a declared one, which has no factors
//   lambda  a factor of the whole IMU, ln lambda ~ N(0, ln^2 5); it does not apply to the rig, the site, or the mount
//   t, o_k  factors of a triad and of the effect, ln ~ N(0, ln^2 2)
//
// A method hands over what its data say of c after everything else is eliminated, ln p(r | c) = -1/2 c.L c + eta.c. For each of a grid of lambda the
// most probable t and o_k are found; the sizes are the roots of their mean squares over the grid, and over the grades where none is declared. With
// priors of these sizes the answer is that of the mixture (in the linear problem of the test to a hundredth). Of a lambda above 4 that the data do
// not make likelier the mean square is not taken: that an IMU is of its class is assumed. No pass over the samples.
#pragma once

#include "imulab/eigen.hpp"

#include <string>
#include <vector>

namespace imulab::kernel {

/// Columns of one effect, which have one size.
struct SizedGroup {
  enum class Of {
    declared,  ///< the size is known: no factors
    rig,       ///< also of the site or the mount, and of a term: its own factor alone
    unit,      ///< of both triads: its own factor and that of the IMU
    accel,     ///< also the factor of its triad
    gyro,
  };
  Eigen::Index first = 0, size = 0;
  Of of = Of::unit;
};

/// Sizes of the groups under one hypothesis, SI, one sigma.
struct SizeHypothesis {
  std::string grade;               ///< empty: the declared one
  double log_weight = 0;           ///< logarithm of its probability, up to a constant, by what is known besides the effects
  std::vector<double> sizes = {};  ///< by group
};

/// What the data say of the effects: -2 ln p(r | c) = c.L c - 2 eta.c + constant.
struct ReducedEffects {
  Eigen::MatrixXd L;
  Eigen::VectorXd eta;
};

/// One lambda of one hypothesis.
struct SizeNode {
  std::size_t hypothesis = 0;
  double log_factor = 0;  ///< ln lambda
  double weight = 0;      ///< probability; the sum over all nodes is 1
  /// By group, logarithms of the factors in its size: all of them, and its own alone; with their variances.
  std::vector<double> log_all = {}, all_variance = {}, log_own = {}, own_variance = {};
};

struct SizePosterior {
  std::vector<double> rms;           ///< by group: root of the mean square of its size, SI
  double log_factor = 0, sigma = 0;  ///< of ln lambda: mean and standard deviation
  std::vector<double> weights;       ///< of the hypotheses; their sum is 1
  std::vector<SizeNode> nodes;
  double log_evidence = 0;  ///< logarithm of p(r) over p(r | c = 0), averaged over the sizes; up to a constant

  /// Probability that a group's factors together exceed `factor`: its size is so many times the hypothesis'.
  double exceeds(std::size_t group, double factor) const;
  /// Probability that a group's own factor exceeds `factor`: it stands out of its IMU.
  double stands_out(std::size_t group, double factor) const;
  /// Probability that lambda exceeds `factor`.
  double factor_exceeds(double factor) const;
};

/// Logarithm of p(r | sizes), up to a constant; `size` by column.
double log_evidence(const ReducedEffects& data, const Eigen::VectorXd& size);
/// eta^T (L + S^-1)^-1 eta: what effects of these sizes take from the cost of data and priors at its minimum.
double explained_cost(const ReducedEffects& data, const Eigen::VectorXd& size);

/// Infers the sizes. Every group has a size above 0 in every hypothesis.
SizePosterior infer_sizes(const ReducedEffects& data, const std::vector<SizedGroup>& groups, const std::vector<SizeHypothesis>& hypotheses);

}  // namespace imulab::kernel
