#include "imulab/rig/quarter_table.hpp"

#include "imulab/rig/pose_on_table.hpp"

#include <algorithm>

namespace imulab::rig {

QuarterPose turned(QuarterPose pose, const QuarterTurn& turn) {
  int& angle = pose[static_cast<std::size_t>(turn.axis)];
  angle = (angle + turn.quarters + 4) % 4;
  return pose;
}

std::vector<QuarterTurn> quarter_turns(const std::vector<RigAxis>& axes) {
  std::vector<QuarterTurn> turns;
  for (const RigAxis axis : axes)
    for (const int quarters : {1, 2, -1, -2}) turns.push_back({axis, quarters});
  return turns;
}

QuarterTable::QuarterTable() {
  for (int p = 0; p < 64; ++p) {
    const QuarterPose angles{p / 16, p / 4 % 4, p % 4};
    PoseOnTable pose;
    for (const RigAxis axis : {RigAxis::outer, RigAxis::middle, RigAxis::inner})
      pose = turned(pose, TableTurn{axis, 90.0 * angles[static_cast<std::size_t>(axis)], 0});
    for (std::size_t a = 0; a < 3; ++a) {
      Eigen::Index along;
      pose.axes[a].cwiseAbs().maxCoeff(&along);
      axis_[place(angles)][a] = {static_cast<std::size_t>(along), pose.axes[a][along] < 0};
    }
    const Matrix3d C_nb = pose.C_nb.array().round();  // exactly one of 24
    const auto found = std::find(attitudes_.begin(), attitudes_.end(), C_nb);
    attitude_[place(angles)] = static_cast<std::size_t>(found - attitudes_.begin());
    if (found == attitudes_.end()) attitudes_.push_back(C_nb);
  }
}

}  // namespace imulab::rig
