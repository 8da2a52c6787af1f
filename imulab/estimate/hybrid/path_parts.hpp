// The parts that paths of quarter turns are made of: rests at 24 attitudes, and the turns between them, as information.
#pragma once

#include "imulab/estimate/hybrid/motion_information.hpp"
#include "imulab/recording/session.hpp"

#include <array>
#include <vector>

namespace imulab::hybrid {

/// A table's angles in quarter turns, 0..3, by RigAxis.
using QuarterPose = std::array<int, 3>;

struct QuarterTurn {
  RigAxis axis;
  int quarters;  ///< 1, 2, -1, -2
  bool operator==(const QuarterTurn&) const = default;
};

/// A path with rests in quanta; rests[0] is before the first turn.
struct QuarterPath {
  std::vector<QuarterTurn> turns;
  std::vector<int> rests;
};

class PathParts {
 public:
  /// Rests of whole numbers of `quantum` s, `most` of it at the longest.
  PathParts(const InformationModel& model, double turn_rate, double acceleration, int quantum, int most);

  const MotionInformation& turn(const QuarterPose& pose, const QuarterTurn& turn) const;
  /// `outermost`: the session's first or last one, the end of which is not used.
  const MotionInformation& rest(const QuarterPose& pose, int quanta, bool outermost) const;
  QuarterPose turned(QuarterPose pose, const QuarterTurn& turn) const;
  double duration(const QuarterTurn& turn) const;  ///< s

 private:
  static std::size_t place(const QuarterPose& pose) { return static_cast<std::size_t>(16 * pose[0] + 4 * pose[1] + pose[2]); }

  double turn_rate_, acceleration_;
  std::array<std::size_t, 64> attitude_;                               // of a pose: one of 24
  std::array<std::array<std::array<std::size_t, 2>, 3>, 64> axis_;     // of a pose's axes: which of n's, and 1 where opposite
  std::vector<std::array<std::array<MotionInformation, 4>, 3>> turn_;  // by attitude, axis of n, and angle
  std::vector<std::array<std::vector<MotionInformation>, 2>> rest_;    // by attitude, outermost and quanta
};

}  // namespace imulab::hybrid
