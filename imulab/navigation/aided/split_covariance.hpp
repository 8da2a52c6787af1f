// The covariance of an aided filter as a sum over its error sources under the filter's gains.
//
//   P = sum of P_s,   P_s <- F P_s F^T + Q_s,   P_s <- (I - K H) P_s (I - K H)^T + K R_s K^T
//
// Q_s and R_s contain only the noise of source s. The sum is valid for any gain; the filter's gain minimizes it.
#pragma once

#include "imulab/navigation/aided/filter.hpp"

#include <Eigen/Core>

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace imulab::aided {

/// An error source: constant errors of states at the start, and fractions of the filter's noises.
struct CovariancePart {
  std::string name;
  std::vector<std::pair<Eigen::Index, double>> states;  // states with their variances
  std::vector<std::pair<std::size_t, double>> noises;   // indices of the problem's sources
};

/// Follows a pass of the filter from the covariance of its start.
class SplitCovariance {
 public:
  /// The problem must outlive it.
  SplitCovariance(const Problem& problem, const FilterStart& start);

  void step(const Transition& transition);
  /// Updates with the rows of an epoch that the filter used.
  void update(const Node& node);

  const Eigen::MatrixXd& total() const { return total_; }
  /// Returns the derivative of the present error by the error at the start.
  const Eigen::MatrixXd& by_start() const { return by_start_; }
  /// Returns the variance of a state due to a part.
  double variance(const CovariancePart& part, Eigen::Index state) const;

 private:
  struct Noise {
    Problem alone;  // input of the covariance laws with only this noise
    Eigen::MatrixXd covariance;
  };
  const Problem& p_;
  Eigen::MatrixXd by_start_, total_;
  std::vector<Noise> noises_;
};

}  // namespace imulab::aided
