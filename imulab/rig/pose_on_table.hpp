// The pose of an IMU on a table that turns about its axes one after the other, and such turns in the IMU's own terms.
#pragma once

#include "imulab/rig/procedure.hpp"
#include "imulab/rig/turntable.hpp"

#include <span>
#include <string>
#include <vector>

namespace imulab::rig {

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

}  // namespace imulab::rig

namespace imulab {
using namespace rig;  // until all callers say rig::
}  // namespace imulab
