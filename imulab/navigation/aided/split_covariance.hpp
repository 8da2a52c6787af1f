// The covariance of an aided filter as a sum over the sources of its errors: what each leaves under the filter's gains.
//
//   P = sum of P_s,   P_s <- F P_s F^T + Q_s,   P_s <- (I - K H) P_s (I - K H)^T + K R_s K^T
//
// Q_s and R_s are zero but for the source's own noise. It holds for every gain: the filter's makes the sum the smallest.
#pragma once

#include "imulab/navigation/aided/filter.hpp"

#include <Eigen/Core>

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace imulab::aided {

/// A source: errors that are constant at the start, by their states, and shares of the filter's noises.
struct CovariancePart {
  std::string name;
  std::vector<std::pair<Eigen::Index, double>> states;  // with their variances
  std::vector<std::pair<std::size_t, double>> noises;   // among the problem's sources
};

/// Follows a pass of the filter, from the covariance of its start on.
class SplitCovariance {
 public:
  /// The problem has to outlive it.
  SplitCovariance(const Problem& problem, const FilterStart& start);

  void step(const Transition& transition);
  /// With the rows of an epoch that the filter has used.
  void update(const Node& node);

  const Eigen::MatrixXd& total() const { return total_; }
  /// Derivative of the present error by the error at the start.
  const Eigen::MatrixXd& by_start() const { return by_start_; }
  /// Variance of a state by a part.
  double variance(const CovariancePart& part, Eigen::Index state) const;

 private:
  struct Noise {
    Problem alone;  // what the laws of the covariance need, with this noise
    Eigen::MatrixXd covariance;
  };
  const Problem& p_;
  Eigen::MatrixXd by_start_, total_;
  std::vector<Noise> noises_;
};

}  // namespace imulab::aided
