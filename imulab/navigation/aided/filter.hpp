// The filter forward and the smoother backward.
#pragma once

#include "imulab/navigation/aided/node_stack.hpp"
#include "imulab/navigation/aided/observation.hpp"
#include "imulab/navigation/aided/problem.hpp"
#include "imulab/navigation/aided/transition.hpp"

#include <algorithm>
#include <cstddef>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

namespace imulab::aided {

/// The weight of a value that is `square` variances off: one within 2.5 sigma, as of Gaussian noise; farther out as of Student's t with 5 degrees of
/// freedom, so that outliers count little. (Student's weights throughout take slow errors for tails, and find them too small.)
inline double tail_weight(double square) {
  constexpr double freedom = 5, core = 2.5 * 2.5;
  return std::min(1., (freedom + core) / (freedom + square));
}

/// The variance of a row's noise.
inline double row_variance(const Problem& problem, const ObservedRows& rows, Eigen::Index k) {
  return problem.sources[rows.source[static_cast<std::size_t>(k)]].factor * rows.variance[k];
}

/// A trajectory about which a pass is linearized: its state after so many samples of the recording, asked for in ascending order; one x for all.
struct AboutTrajectory {
  std::function<NavigationState(std::size_t samples)> at;
  Eigen::VectorXd x;
  std::vector<Eigen::VectorXd> weights;  // of the rows of each observation; empty: from the innovations
};

struct FilterOptions {
  const AboutTrajectory* about = nullptr;                     // null: the filter's own, corrected at each epoch
  std::size_t end = std::numeric_limits<std::size_t>::max();  // samples
  bool keep = true;                                           // all nodes, for the smoother; otherwise the last
  /// Called after each epoch's update, with the step from the epoch before (null at the first) and the covariance of the first nine before it.
  std::function<void(const Transition* step, const Matrix9& predicted, const Node& node)> each = {};
};

/// A matrix times a vector of which most is zero, as of a row's derivative.
Eigen::VectorXd times(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& h);

/// A row's update of a covariance by a gain K, (I - K h) P (I - K h)^T + K r K^T: positive, and right of every gain.
void update_covariance(Eigen::MatrixXd& covariance, const Eigen::VectorXd& h, const Eigen::VectorXd& gain, double noise);

/// Of all states at the start: those of stationary errors are as large as their noise makes them.
Eigen::VectorXd start_variance(const Problem& problem, const FilterStart& start);

struct FilterPass {
  NodeStack nodes;
  double log_likelihood = 0;
};
FilterPass filter(const Problem& problem, const FilterStart& start, const FilterOptions& options = {});

/// What the smoother says of each source of noise: the sum of squares of its estimates over their variance, and the number of them that the data
/// resolve; their quotient is one where the variance is right (the fixed point of the restricted likelihood).
struct NoiseEvidence {
  double squares = 0, resolved = 0;
};

struct SmoothedNode {
  std::size_t samples = 0;  // of the recording before it
  FullState state;
  Eigen::MatrixXd covariance;  // of the first nine
  Eigen::VectorXd variance;    // of all, at the last node alone
};
/// What was withheld, less what the states predict, and the variance of that.
struct Withheld {
  std::size_t observation = 0, source = 0;  // of the first row
  Eigen::VectorXd residual, variance;
};
struct SmootherPass {
  std::vector<SmoothedNode> nodes;
  std::vector<NoiseEvidence> evidence;   // by source
  std::vector<Eigen::VectorXd> weights;  // by observation
  std::vector<Withheld> withheld;
  std::size_t middle = 0;             // the node in the middle of the time
  Eigen::MatrixXd middle_covariance;  // of all states there
};
/// Takes the nodes from the pass. Without `covariances` those of the nodes are left out.
SmootherPass smooth(const Problem& problem, FilterPass pass, bool covariances = true);

/// States after so many samples of the recording.
struct EpochStates {
  std::vector<std::size_t> samples;
  std::vector<FullState> states;
};
/// The states after each sample from epoch k to the next, integrated from epoch k: the small misfit at the end spread evenly.
std::vector<NavigationState> states_between(const Problem& problem, const EpochStates& epochs, std::size_t k);
/// For AboutTrajectory; the problem has to outlive it.
std::function<NavigationState(std::size_t samples)> trajectory_of(const Problem& problem, EpochStates epochs);

}  // namespace imulab::aided
