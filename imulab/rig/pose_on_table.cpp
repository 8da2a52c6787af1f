#include "imulab/rig/pose_on_table.hpp"

#include "imulab/core/rotation.hpp"
#include "imulab/rig/motion.hpp"
#include "imulab/rig/rig_errors.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace imulab {

PoseOnTable turned(PoseOnTable pose, const TableTurn& turn) {
  const Matrix3d rotation = rotation_about(pose.axis(turn), turn.angle_deg * unit::deg);
  for (auto a = static_cast<std::size_t>(turn.axis); a < 3; ++a) pose.axes[a] = rotation * pose.axes[a];
  pose.C_nb = rotation * pose.C_nb;
  return pose;
}

PoseOnTable pose_at_end(std::span<const Step> steps) {
  const RigMotion motion = rig_motion(steps);
  PoseOnTable end;
  for (std::size_t a = 0; a < 3; ++a) {
    AxisStates states = axis_states(motion.pieces.back(), motion.end());
    for (AxisState& state : states) state.rate = 0;
    states[a].rate = 1;
    const BodyState turning = turntable_state(motion.axes, states);
    end.C_nb = turning.C_nb;
    end.axes[a] = turning.C_nb * turning.rate_nb_b;
  }
  return end;
}

std::string in_words(const PoseOnTable& pose, const TableTurn& turn) {
  const Vector3d axis = pose.axis(turn), body = pose.C_nb.transpose() * axis;
  Eigen::Index along;
  const bool of_body = body.cwiseAbs().maxCoeff(&along) > 0.999;
  const double up = std::abs(axis.z());
  const char* stands = up > 0.999 ? "vertical" : (up < 0.045 ? "horizontal" : "inclined");
  if (!of_body) return fmt::format("turn by {:g} deg about the {} axis, which is {} then", turn.angle_deg, to_string(turn.axis), stands);
  return fmt::format("turn by {:g} deg about the IMU's {} axis while it is {}", body[along] < 0 ? -turn.angle_deg : turn.angle_deg, "xyz"[along],
                     stands);
}

std::vector<std::string> in_words(std::span<const TableTurn> turns) {
  PoseOnTable pose;
  std::vector<std::string> out;
  for (const TableTurn& turn : turns) {
    out.push_back(in_words(pose, turn));
    pose = turned(pose, turn);
  }
  return out;
}

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

}  // namespace imulab
