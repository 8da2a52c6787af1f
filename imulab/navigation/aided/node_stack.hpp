// Stores the epochs of a filter pass for the smoother, which reads them from the last to the first.
//
// An epoch of 50 states has 20 kB, a day at 1 Hz 1.8 GB: the last epoch stays in memory, earlier ones are numbers in a block, and full blocks are
// written to a temporary file and read back from it. Twenty minutes at 1 Hz need no file.
#pragma once

#include "imulab/core/temporary_file.hpp"
#include "imulab/navigation/aided/observation.hpp"
#include "imulab/navigation/aided/problem.hpp"
#include "imulab/navigation/aided/transition.hpp"

#include <Eigen/Core>

#include <cstddef>
#include <optional>
#include <vector>

namespace imulab::aided {

/// Linearized observations at one epoch, with the weight of each row (1: within its noise).
struct EpochRows {
  std::size_t observation = 0;
  ObservedRows rows;
  Eigen::VectorXd weight;
  Eigen::VectorXd innovation, innovation_variance;  // before the update
  Eigen::MatrixXd gain;                             // one column for each row that was used
};

/// An epoch of the filter: the state after `samples` samples of the recording.
struct Node {
  std::size_t samples = 0;
  FullState reference;              // point of linearization after the update
  Eigen::VectorXd error;            // filtered error state relative to `reference`
  Eigen::MatrixXd covariance;       // filtered; symmetric
  Transition next;                  // to the next node
  std::vector<EpochRows> rows;      // observations that were used
  std::vector<EpochRows> withheld;  // predicted observations; their residuals refer to the mean after the update
};

/// The stack of epochs. Throws Error if a temporary file cannot be created, written or read.
class NodeStack {
 public:
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  /// Returns the last node.
  Node& back() { return last_; }
  const Node& back() const { return last_; }
  void push(Node node);
  /// Replaces all nodes by this one.
  void replace(Node node);
  Node pop();

 private:
  std::size_t size_ = 0;
  Node last_;
  std::vector<double> block_;         // nodes before the last, as numbers
  std::vector<std::size_t> numbers_;  // size of each of those nodes, including filed ones
  std::vector<std::size_t> filed_;    // size of each full block
  std::optional<TemporaryFile> file_;
};

}  // namespace imulab::aided
