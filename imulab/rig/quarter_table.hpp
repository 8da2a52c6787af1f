// A table that turns by quarters: 64 poses of its axes, and the 24 attitudes that these give the IMU.
#pragma once

#include "imulab/recording/session.hpp"
#include "imulab/rig/turntable.hpp"

#include <array>
#include <cstddef>
#include <vector>

namespace imulab::rig {

/// A table's angles in quarter turns, 0..3, by RigAxis.
using QuarterPose = std::array<int, 3>;

struct QuarterTurn {
  RigAxis axis;
  int quarters;  ///< 1, 2, -1, -2
  bool operator==(const QuarterTurn&) const = default;
};
QuarterPose turned(QuarterPose pose, const QuarterTurn& turn);
/// All turns about these axes.
std::vector<QuarterTurn> quarter_turns(const std::vector<RigAxis>& axes);

/// A path with rests in multiples of some time; rests[0] is before the first turn.
struct QuarterPath {
  std::vector<QuarterTurn> turns;
  std::vector<int> rests;
};

class QuarterTable {
 public:
  QuarterTable();

  const std::vector<Matrix3d>& attitudes() const { return attitudes_; }  ///< C_nb
  /// Index of the attitude in a pose.
  std::size_t attitude(const QuarterPose& pose) const { return attitude_[place(pose)]; }

  /// A table's axis in a pose: along which one of n it lies, and whether in the opposite direction.
  struct Direction {
    std::size_t along;
    bool opposite;
  };
  const Direction& axis(const QuarterPose& pose, RigAxis axis) const { return axis_[place(pose)][static_cast<std::size_t>(axis)]; }

 private:
  static std::size_t place(const QuarterPose& pose) {
    return 16 * static_cast<std::size_t>(pose[0]) + 4 * static_cast<std::size_t>(pose[1]) + static_cast<std::size_t>(pose[2]);
  }

  std::vector<Matrix3d> attitudes_;
  std::array<std::size_t, 64> attitude_;
  std::array<std::array<Direction, 3>, 64> axis_;
};

}  // namespace imulab::rig

namespace imulab {
using namespace rig;  // until all callers say rig::
}  // namespace imulab
