// The forward filter and the backward smoother.
#pragma once

#include "imulab/navigation/aided/node_stack.hpp"
#include "imulab/navigation/aided/observation.hpp"
#include "imulab/navigation/aided/problem.hpp"
#include "imulab/navigation/aided/transition.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

namespace imulab::aided {

/// Returns the weight of a value with this squared normalized deviation: within 2.5 sigma that of Gaussian noise, beyond it that of Student's t with
/// 5 degrees of freedom, which reduces the weight of outliers. (Student weights throughout would treat slow errors as tails and underestimate them.)
inline double tail_weight(double square) {
  constexpr double freedom = 5, core = 2.5 * 2.5;
  return std::min(1., (freedom + core) / (freedom + square));
}

/// Returns the variance of a row's noise.
inline double row_variance(const Problem& problem, const ObservedRows& rows, Eigen::Index k) {
  return problem.sources[rows.source[static_cast<std::size_t>(k)]].factor * rows.variance[k];
}

/// A trajectory about which a pass is linearized: its state after a number of samples, requested in ascending order; x is common to all.
struct AboutTrajectory {
  std::function<NavigationState(std::size_t samples)> at;
  Eigen::VectorXd x;
  std::vector<Eigen::VectorXd> weights;  // weights of the rows of each observation; empty: computed from the innovations
};

struct FilterOptions {
  const AboutTrajectory* about = nullptr;                     // null: the filter's own trajectory, corrected at each epoch
  std::size_t end = std::numeric_limits<std::size_t>::max();  // in samples
  bool keep = true;                                           // keeps all nodes for the smoother; otherwise the last
  /// Called after each epoch's update with the step from the previous epoch (null at the first) and the predicted covariance of motion.
  std::function<void(const Transition* step, const Matrix9& predicted, const Node& node)> each = {};
};

/// Returns the product of a matrix and a mostly zero vector, such as the derivative of a row.
Eigen::VectorXd times(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& h);

/// Updates a covariance by a row with gain K, (I - K h) P (I - K h)^T + K r K^T: positive, and correct for any gain.
void update_covariance(Eigen::MatrixXd& covariance, const Eigen::VectorXd& h, const Eigen::VectorXd& gain, double noise);

/// Returns the variance of all states at the start; stationary errors have the size that corresponds to their noise.
Eigen::VectorXd start_variance(const Problem& problem, const FilterStart& start);

struct FilterPass {
  NodeStack nodes;
  double log_likelihood = 0;
};
FilterPass filter(const Problem& problem, const FilterStart& start, const FilterOptions& options = {});

/// Evidence of the smoother about a noise source: the sum of squares of its estimates over their variance, and the number of resolved estimates.
/// Their ratio is one if the variance is correct (the fixed point of the restricted likelihood).
struct NoiseEvidence {
  double squares = 0, resolved = 0;
  void add(double square, double fraction) { squares += square, resolved += fraction; }
};
/// Evidence of the triads' noise during one kind of motion.
struct MotionEvidence {
  NoiseEvidence gyro, accel;
};

struct SmoothedNode {
  std::size_t samples = 0;  // number of samples of the recording before it
  FullState state;
  Eigen::MatrixXd covariance;  // covariance of the first nine states
  Eigen::VectorXd variance;    // variance of all states, only at the last node
};
/// Withheld values minus their prediction, and the variance of the difference.
struct Withheld {
  std::size_t observation = 0, source = 0;  // source of the first row
  Eigen::VectorXd residual, variance;
};
struct SmootherPass {
  std::vector<SmoothedNode> nodes;
  std::vector<NoiseEvidence> evidence;  // evidence for each source
  std::array<MotionEvidence, motion_kinds.size()> motion;
  std::vector<Eigen::VectorXd> weights;  // weights for each observation
  std::vector<Withheld> withheld;
  std::size_t middle = 0;             // node in the middle of the time
  Eigen::MatrixXd middle_covariance;  // covariance of all states at that node
};
/// Smooths, and consumes the nodes of the pass. Without `covariances`, those of the nodes are omitted.
SmootherPass smooth(const Problem& problem, FilterPass pass, bool covariances = true);

/// States after given numbers of samples of the recording.
struct EpochStates {
  std::vector<std::size_t> samples;
  std::vector<FullState> states;
};
/// Returns the states after each sample from epoch k to the next, integrated from epoch k; the small misfit at the end is distributed evenly.
std::vector<NavigationState> states_between(const Problem& problem, const EpochStates& epochs, std::size_t k);
/// Returns a trajectory for AboutTrajectory; the problem must outlive it.
std::function<NavigationState(std::size_t samples)> trajectory_of(const Problem& problem, EpochStates epochs);

}  // namespace imulab::aided
