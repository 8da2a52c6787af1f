// A path compared with the requirements, from its parts.
#pragma once

#include "imulab/estimate/hybrid/path_design.hpp"
#include "imulab/estimate/hybrid/path_parts.hpp"

#include <vector>

namespace imulab::hybrid {

inline constexpr int shortest_rest = 10, longest_rest = 300;  ///< s, where rests are chosen

/// Of the part of sigma that data can make smaller, sqrt(sigma^2 - floor^2), to its requirement: the worst ratio, at most 1 where every sigma
/// is within its limit, and the sum of the logarithms, a measure of progress while most coefficients are undetermined.
struct Score {
  double worst = 0, sum = 0;
};

class PathJudge {
 public:
  explicit PathJudge(const PathQuestion& question);

  Knowledge start() const { return prior_knowledge(model_); }
  Knowledge knowledge(const QuarterPath& path) const;
  Score score(const Knowledge& knowledge) const;
  double worst(const QuarterPath& path) const { return score(knowledge(path)).worst; }
  double duration(const QuarterPath& path) const;  ///< s
  std::size_t limits() const { return limits_.size(); }
  /// With the coefficient whose sigma is the largest of its limit.
  Path described(const QuarterPath& path) const;

 private:
  struct Limit {
    Eigen::Index row;
    CoefficientIndex coefficient;
    double limit, floor;
  };
  InformationModel model_;
  std::vector<Limit> limits_;

 public:
  const int quantum;  ///< of a rest, s
  const PathParts parts;
};

}  // namespace imulab::hybrid
