#include "imulab/rig/table_states.hpp"

#include "imulab/rig/rig_errors.hpp"
#include "imulab/units.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace imulab {

namespace {

/// The accelerometers' play after each step.
std::vector<Vector3d> play_after_steps(const TableMotion& motion, const TablePlan& plan, double gravity) {
  constexpr double finest = unit::deg;  // half of this beside an extreme of the force is a thousandth of the play's width
  PlayOperator play(gravity);
  std::vector<Vector3d> out;
  for (const AxisCommand& command : commands_of(plan.steps)) {
    const bool turns = plan.steps[out.size()].kind == StepKind::rotate;
    std::array<double, 3> way{};
    double longest = 0;
    for (std::size_t a = 0; a < 3; ++a) {
      const double whole = command.after[a] - command.before[a];
      if (command.moves[a]) way[a] = turns ? whole : std::fmod(whole, 2 * std::numbers::pi);  // as rig_motion has it
      longest = std::max(longest, std::abs(way[a]));
    }
    const int pieces = std::max(1, static_cast<int>(std::ceil(longest / finest)));
    Vector3d state;
    for (int k = out.empty() ? 0 : 1; k <= pieces; ++k) {
      std::array<double, 3> angles = command.before;
      for (std::size_t a = 0; a < 3; ++a) angles[a] += way[a] * k / pieces;
      state = play(motion.force_at(angles));
    }
    out.push_back(state);
  }
  return out;
}

}  // namespace

std::vector<std::vector<WeightedState>> table_states(const TableMotion& motion, const TablePlan& plan, double gravity,
                                                     std::optional<std::size_t> changed_at) {
  const std::vector<Vector3d> play = play_after_steps(motion, plan, gravity);
  // The higher orders are declared as parts of the full scale, which is that of no IMU below a radian a second.
  double full_rate = EffectState().full_rate;
  for (const Step& step : plan.steps)
    if (step.kind == StepKind::rotate) full_rate = std::max(full_rate, step.rate);
  std::vector<std::vector<WeightedState>> out(motion.parts());
  for (std::size_t k = 0; k < motion.parts(); ++k)
    for (const TableMotion::Moment& m : motion.moments(k)) {
      EffectState state{.force = m.force, .rate = m.rate, .gravity = gravity};
      state.full_rate = full_rate;
      state.time = (m.time - plan.begin) / std::max(plan.end - plan.begin, 1e-9) - 0.5;
      const TablePart& part = motion.is_hold(k) ? plan.holds[k] : plan.turns[k - motion.holds()];
      state.play = play[motion.step(k)];
      state.shaking = part.shaking;
      state.warming = part.warming;
      state.changed = changed_at && motion.step(k) >= *changed_at ? 1 : 0;
      out[k].push_back({state, m.weight, m.C_bn});
    }
  return out;
}

}  // namespace imulab
