// A path of quarter turns compared with the requirements, from its parts: rests at 24 attitudes, and the turns between them, as information. And a
// beam search over the turns of paths all rests of which are equal.
#pragma once

#include "imulab/estimate/hybrid/motion_information.hpp"
#include "imulab/estimate/hybrid/path_design.hpp"
#include "imulab/rig/pose_on_table.hpp"

#include <array>
#include <cmath>
#include <vector>

namespace imulab::hybrid {

inline constexpr int shortest_rest = 10, longest_rest = 300;  ///< s, where rests are chosen

/// Ratios of the part of sigma that data can reduce, sqrt(sigma^2 - floor^2), to its requirement: the worst one, at most 1 where every sigma
/// is within its limit, and the sum of the logarithms, a measure of progress while most coefficients are undetermined.
struct Score {
  double worst = 0, sum = 0;
};

/// The place of a logarithm on a grid of 1e-7: what differs by rounding alone, as mirror images of a path do, is equal, so that the search does not
/// depend on it.
inline double grid_place(double logarithm) { return std::round(1e7 * logarithm); }

class PathJudge {
 public:
  explicit PathJudge(const PathQuestion& question);

  const int quantum;  ///< of a rest, s

  Knowledge start() const { return prior_knowledge(model_); }
  const MotionInformation& turn(const QuarterPose& pose, const QuarterTurn& turn) const;
  /// `outermost`: the session's first or last one, the end of which is not used.
  const MotionInformation& rest(const QuarterPose& pose, int quanta, bool outermost) const;
  double duration(const QuarterTurn& turn) const;  ///< s
  double duration(const QuarterPath& path) const;  ///< s

  Knowledge knowledge(const QuarterPath& path) const;
  Score score(const Knowledge& knowledge) const;
  double worst(const QuarterPath& path) const { return score(knowledge(path)).worst; }
  std::size_t limits() const { return limits_.size(); }
  /// With the coefficient whose sigma is the largest of its limit.
  TurnPath described(const QuarterPath& path) const;

 private:
  void find_limits(const PathQuestion& question);

  struct Limit {
    Eigen::Index row;
    CoefficientIndex coefficient;
    double limit, floor, nonlinear;
    double sigma(double of_path) const { return std::hypot(of_path, nonlinear); }
  };
  InformationModel model_;
  double turn_rate_;
  std::vector<Limit> limits_;
  QuarterTable table_;
  std::vector<std::array<std::array<MotionInformation, 4>, 3>> turn_;  // by attitude, axis of n, and angle
  std::vector<std::array<std::vector<MotionInformation>, 2>> rest_;    // by attitude, outermost and quanta
};

struct Candidate {
  QuarterPath path;
  double merit;  ///< smaller is better: the time to meet the requirements if rests and turns were lengthened equally
  bool within;   ///< the limits
};

/// Paths from zero angles of these moves, with every rest `rest` quanta and all in all at most `longest` [s]: each that was better than those before.
/// Those within the limits are the better the shorter they are or, where all the time is given, the more they leave of the limits.
std::vector<Candidate> search_turns(const PathJudge& judge, const std::vector<QuarterTurn>& moves, int rest, double longest, bool all_the_time);

}  // namespace imulab::hybrid
