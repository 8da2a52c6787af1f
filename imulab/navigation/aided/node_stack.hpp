// The epochs of a pass of the filter, for the smoother, which reads them from the last to the first.
//
// An epoch of 50 states is 20 kB, a day at 1 Hz 1.8 GB: the last one is in memory, those before it as numbers in a block, and full blocks in a
// temporary file, from which they are taken back. Twenty minutes at 1 Hz make no file.
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

/// Observations at one epoch, linearized, with the weight of each row (1: within its noise).
struct EpochRows {
  std::size_t observation = 0;
  ObservedRows rows;
  Eigen::VectorXd weight;
  Eigen::VectorXd innovation, innovation_variance;  // before the update
  Eigen::MatrixXd gain;                             // of each row, a column; of those that were used
};

/// An epoch of the filter: the state after `samples` samples of the recording.
struct Node {
  std::size_t samples = 0;
  FullState reference;              // the point of linearization after the update
  Eigen::VectorXd error;            // filtered error state about `reference`
  Eigen::MatrixXd covariance;       // filtered; symmetric
  Transition next;                  // to the next node
  std::vector<EpochRows> rows;      // used
  std::vector<EpochRows> withheld;  // predicted; their residuals are about the mean after the update
};

/// Throws Error where a temporary file cannot be made, written or read.
class NodeStack {
 public:
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  /// The last one.
  Node& back() { return last_; }
  const Node& back() const { return last_; }
  void push(Node node);
  /// The last one in place of all.
  void replace(Node node);
  Node pop();

 private:
  std::size_t size_ = 0;
  Node last_;
  std::vector<double> block_;         // nodes before the last as numbers
  std::vector<std::size_t> numbers_;  // of each of those nodes, the filed ones too
  std::vector<std::size_t> filed_;    // numbers of each full block
  std::optional<TemporaryFile> file_;
};

}  // namespace imulab::aided
