#include "imulab/rig/pose_on_table.hpp"

#include "imulab/rig/motion.hpp"

#include <fmt/core.h>

#include <cmath>

namespace imulab::rig {

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

}  // namespace imulab::rig
