// The filter forward and the smoother backward.
#pragma once

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

/// Observations at one epoch, linearized, with the weight of each row (1: within its noise).
struct EpochRows {
  std::size_t observation = 0;
  ObservedRows rows;
  Eigen::VectorXd weight;
  Eigen::VectorXd innovation, innovation_variance;  // before the update
};

/// An epoch of the filter: the state after `samples` samples of the recording.
struct Node {
  std::size_t samples = 0;
  FullState reference;              // the point of linearization after the update
  Eigen::VectorXd correction;       // that was added to it by the update; zero where the references are given
  Eigen::VectorXd error;            // filtered error state about `reference`
  Eigen::MatrixXd covariance;       // filtered
  Transition next;                  // to the next node
  Eigen::VectorXd defect;           // what the integration from `reference` gives, less the reference there
  std::vector<EpochRows> rows;      // used
  std::vector<EpochRows> withheld;  // predicted
};

/// A trajectory about which a pass is linearized: a state before each sample and after the last, from the start's sample on; one x for all.
struct AboutTrajectory {
  std::vector<NavigationState> states;
  Eigen::VectorXd x;
  std::vector<Eigen::VectorXd> weights;  // of the rows of each observation; empty: from the innovations
};

struct FilterOptions {
  const AboutTrajectory* about = nullptr;                     // null: the filter's own, corrected at each epoch
  std::size_t end = std::numeric_limits<std::size_t>::max();  // samples
  bool keep = true;                                           // all nodes; otherwise the last
  /// Called after each epoch's update, with the step from the epoch before; null at the first.
  std::function<void(const Transition* step, const Node& node)> each = {};
};

/// A row's update of a covariance by a gain K, (I - K h) P (I - K h)^T + K r K^T: positive, and right of every gain.
void update_covariance(Eigen::MatrixXd& covariance, const Eigen::VectorXd& h, const Eigen::VectorXd& gain, double noise);

/// Of all states at the start: those of stationary errors are as large as their noise makes them.
Eigen::VectorXd start_variance(const Problem& problem, const FilterStart& start);

struct FilterPass {
  std::vector<Node> nodes;
  double log_likelihood = 0;
};
FilterPass filter(const Problem& problem, const FilterStart& start, const FilterOptions& options = {});

/// What the smoother says of each source of noise: the sum of squares of its estimates over their variance, and the number of them that the data
/// resolve; their quotient is one where the variance is right (the fixed point of the restricted likelihood).
struct NoiseEvidence {
  double squares = 0, resolved = 0;
};

struct SmoothedNode {
  FullState state;
  Eigen::VectorXd error;       // about the node's reference
  Eigen::MatrixXd covariance;  // of the first nine
  Eigen::VectorXd variance;    // of all
};
struct SmoothedWithheld {
  std::size_t node = 0, index = 0;  // of Node::withheld
  Eigen::VectorXd residual, variance;
};
struct SmootherPass {
  std::vector<SmoothedNode> nodes;
  std::vector<NoiseEvidence> evidence;   // by source
  std::vector<Eigen::VectorXd> weights;  // by observation
  std::vector<SmoothedWithheld> withheld;
  std::size_t middle = 0;             // the node in the middle of the time
  Eigen::MatrixXd middle_covariance;  // of all states there
};
SmootherPass smooth(const Problem& problem, const FilterPass& pass);

/// The state after each sample from the first node to the last: integrated from node to node, the small misfit at the end spread evenly.
AboutTrajectory trajectory_of(const Problem& problem, const std::vector<std::size_t>& samples, const std::vector<FullState>& states);

}  // namespace imulab::aided
