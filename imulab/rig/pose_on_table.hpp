// The pose of an IMU on a table that turns about its axes one after the other, and such turns in the IMU's own terms.
//
// A turn about an axis carries the axes inside it: the outer axis carries the middle one, which carries the inner one.
#pragma once

#include "imulab/procedure.hpp"
#include "imulab/rig/motion.hpp"
#include "imulab/rig/rig_errors.hpp"
#include "imulab/session.hpp"

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace imulab {

/// Attitude, and the directions of the table's axes in n; by default at zero angles.
struct PoseOnTable {
  Matrix3d C_nb = Matrix3d::Identity();
  RigAxes axes = ideal_axes();
  const Vector3d& axis(const TableTurn& turn) const { return axes[static_cast<std::size_t>(turn.axis)]; }
};

/// After a turn: the outer axis carries the middle one, and that the inner one.
PoseOnTable turned(PoseOnTable pose, const TableTurn& turn);

/// At the end of these steps (of one recording).
PoseOnTable pose_at_end(std::span<const Step> steps);

/// "turn by 180 deg about the IMU's z axis while it is horizontal"
std::string in_words(const PoseOnTable& pose, const TableTurn& turn);
/// Turns from zero angles.
std::vector<std::string> in_words(std::span<const TableTurn> turns);

// A table that turns by quarters: 64 poses of its axes, and the 24 attitudes that these give the IMU.

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

}  // namespace imulab
