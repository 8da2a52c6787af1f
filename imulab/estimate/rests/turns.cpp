#include "imulab/estimate/rests/turns.hpp"

#include "imulab/rig/rig_errors.hpp"
#include "imulab/rig/table_attitude.hpp"
#include "imulab/units.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace imulab::rests {

namespace {

constexpr double whole_turn = 2 * std::numbers::pi;

std::string body_axis_name(const Vector3d& axis) {
  Eigen::Index along;
  axis.cwiseAbs().maxCoeff(&along);
  return fmt::format("{}{}", axis[along] < 0 ? '-' : '+', "xyz"[along]);
}

}  // namespace

double DeclaredTurn::angle_sigma() const {
  constexpr double second_order = 1e-3;  // [rad], the square of an axis error of 2 deg
  return std::hypot(std::numbers::sqrt2 * sigma, second_order);
}

double DeclaredTurn::tilt_sigma() const {
  constexpr double between_triads = 0.08;  // [rad], a generous limit for errors of uncalibrated axes and a hand
  return between_triads * angle_sigma();
}

std::vector<DeclaredTurn> declared_turns(const Session& session, const RecordingSource& source) {
  std::vector<DeclaredTurn> turns;
  const RigDeclaration* const rig = session.rig_of(source);
  if (rig == nullptr || !(rig->kind == RigKind::turntable || (rig->kind == RigKind::none && rig->angle.value > 0))) return turns;
  const std::vector<Step> steps = session.steps_of(source);
  const std::vector<AxisCommand> commands = commands_of(steps);
  const TableAxes<double> axes = table_axes<double>({});
  for (std::size_t k = 0; k < steps.size(); ++k) {
    const Step& step = steps[k];
    if (step.kind != StepKind::rotate) continue;
    const bool moves_on = k + 1 < steps.size() && steps[k + 1].kind == StepKind::hold && steps[k + 1].start > step.end + same_time &&
                          std::find(commands[k + 1].moves.begin(), commands[k + 1].moves.end(), true) != commands[k + 1].moves.end();
    const double sigma = rig->angle.fixed ? 0 : rig->angle.value;  // an equal error at both rests cancels
    turns.push_back({step.start, step.end, step.axis, axis_in_body(table_pose(axes, commands[k].before), step.axis), step.angle, sigma, moves_on});
  }
  return turns;
}

double angle_beyond(const DeclaredTurn& turn, const Matrix3d& C, const Vector3d& swept) {
  const double beyond = turn.axis_b.dot(rotation_log(rotation_about(turn.axis_b, -turn.angle) * C));
  return beyond + whole_turn * std::round((turn.axis_b.dot(swept) - turn.angle - beyond) / whole_turn);
}

std::string contradiction(const DeclaredTurn& turn, const Vector3d& swept, double scale) {
  if ((swept - turn.angle * turn.axis_b).norm() <= scale * std::abs(turn.angle) + 5 * turn.angle_sigma()) return {};
  const std::string declared = fmt::format("the turn at {:.1f} s is declared as {:.0f} deg about {} ({})", turn.middle(), turn.angle / unit::deg,
                                           body_axis_name(turn.axis_b), to_string(turn.axis));
  const double angle = swept.norm();
  if (angle < 5 * unit::deg) return fmt::format("{}, but the gyros show none", declared);
  return fmt::format("{}, but the gyros turned by {:.0f} deg about {}", declared, angle / unit::deg, body_axis_name(swept));
}

}  // namespace imulab::rests
