// Evaluates a path of quarter turns against the requirements from its parts, as information: rests at 24 attitudes, and the turns between them. Also
// a beam search over the turns of paths with equal rests.
#pragma once

#include "imulab/estimate/hybrid/motion_information.hpp"
#include "imulab/estimate/hybrid/path_design.hpp"
#include "imulab/rig/pose_on_table.hpp"

#include <array>
#include <cmath>
#include <vector>

namespace imulab::hybrid {

inline constexpr int shortest_rest = 10, longest_rest = 300;  ///< [s], if rests are chosen

/// The largest ratio of the reducible part of a sigma, sqrt(sigma^2 - floor^2), to its requirement, at most 1 if every sigma is within its limit; and
/// the sum of the logarithms, which measures progress while most coefficients are undetermined.
struct Score {
  double worst = 0, sum = 0;
};

/// Rounds a logarithm to a grid of 1e-7, so that values that differ only by rounding, such as those of mirrored paths, are equal and the search does
/// not depend on rounding.
inline double grid_place(double logarithm) { return std::round(1e7 * logarithm); }

class PathJudge {
 public:
  explicit PathJudge(const PathQuestion& question);

  const int quantum;  ///< step of the duration of a rest [s]

  Knowledge start() const { return prior_knowledge(model_); }
  const MotionInformation& turn(const QuarterPose& pose, const QuarterTurn& turn) const;
  /// `outermost`: the first or last rest of the session, whose end is not used.
  const MotionInformation& rest(const QuarterPose& pose, int quanta, bool outermost) const;
  double duration(const QuarterTurn& turn) const;  ///< s
  double duration(const QuarterPath& path) const;  ///< s

  Knowledge knowledge(const QuarterPath& path) const;
  Score score(const Knowledge& knowledge) const;
  double worst(const QuarterPath& path) const { return score(knowledge(path)).worst; }
  std::size_t limits() const { return limits_.size(); }
  /// Describes a path with the coefficient whose sigma is largest relative to its limit.
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
  std::vector<std::array<std::array<MotionInformation, 4>, 3>> turn_;  // index: attitude, axis of n, and angle
  std::vector<std::array<std::vector<MotionInformation>, 2>> rest_;    // index: attitude, outermost, and quanta
};

struct Candidate {
  QuarterPath path;
  double merit;  ///< smaller is better: the time to meet the requirements if rests and turns were lengthened equally
  bool within;   ///< the path is within the limits
};

/// Searches paths of these moves from zero angles, with every rest `rest` quanta and a total of at most `longest` [s], and returns each that improved
/// on earlier ones. Within the limits, shorter paths are better or, if all the time is given, paths with a larger margin.
std::vector<Candidate> search_turns(const PathJudge& judge, const std::vector<QuarterTurn>& moves, int rest, double longest, bool all_the_time);

}  // namespace imulab::hybrid
