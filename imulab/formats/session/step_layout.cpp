#include "imulab/formats/session/step_layout.hpp"

#include "imulab/recording/turn.hpp"
#include "imulab/units.hpp"

#include <fmt/core.h>

#include <cmath>

namespace imulab::session_io {
namespace {

bool differ(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  constexpr double rounding = 1e-9;  // deg: what sums of decimal fractions leave, far below any table's resolution
  for (std::size_t i = 0; i < 3; ++i)
    if (std::abs(a[i] - b[i]) > rounding) return true;
  return false;
}

/// The problem of a step's given times, start_s or end_s among them.
std::optional<StepLayout::StepProblem> problem_of_times(const StepText& text, const RigState& rig) {
  using StepProblem = StepLayout::StepProblem;
  if (!text.start_s) return StepProblem{"end_s", "is given alone; expected start_s, too"};
  if (!text.end_s) return StepProblem{"start_s", "is given alone; expected end_s, too"};
  if (text.duration_s) return StepProblem{"duration_s", "cannot be combined with start_s and end_s; expected one or the other"};
  if (text.move_s) return StepProblem{"move_s", "cannot be combined with start_s and end_s; expected one or the other"};
  if (*text.end_s <= *text.start_s)
    return StepProblem{"end_s", fmt::format("{} is not after start_s; expected more than {}", *text.end_s, *text.start_s)};
  if (rig.begun && *text.start_s < rig.time)
    return StepProblem{"start_s", fmt::format("{} is before the end of the previous step; expected at least {}", *text.start_s, rig.time)};
  return std::nullopt;
}

/// True if the rig moves between two holds or spins.
bool moves(const RigState& before, const RigState& after) {
  return differ(after.angles_deg, before.angles_deg) || after.spin_dps != before.spin_dps ||
         (before.begun && (after.mount.value_or(Mount{}) != before.mount.value_or(Mount{}) || after.temperature != before.temperature));
}

}  // namespace

std::optional<StepLayout::StepProblem> StepLayout::place(const StepText& text, const std::string& recording, Step& step) {
  RigState& rig = rigs_[recording];
  RigState next = rig;
  next.begun = true;
  if (text.kind == StepKind::hold)
    for (std::size_t a = 0; a < 3; ++a) next.angles_deg[a] = text.angles_deg[a].value_or(rig.angles_deg[a]);
  next.spin_dps = text.kind == StepKind::spin ? text.rate_dps : 0;
  if (text.up && text.outward) next.mount = Mount{*text.up, *text.outward};
  if (text.temperature_degC) next.temperature = text.temperature_degC;
  step.acceleration = text.acceleration_dps2 ? std::optional(*text.acceleration_dps2 * unit::deg) : std::nullopt;

  if (text.start_s || text.end_s) {
    if (auto problem = problem_of_times(text, rig)) return problem;
    step.start = *text.start_s;
    step.end = *text.end_s;
  } else if (text.kind == StepKind::rotate) {  // of a procedure
    const double acceleration = text.acceleration_dps2.value_or(default_acceleration_dps2);
    step.acceleration = acceleration * unit::deg;
    step.start = rig.time;
    step.end = step.start + turn_duration(text.angle_deg, text.rate_dps, acceleration);
  } else {
    if (!text.duration_s) return StepProblem{"duration_s", "is missing; expected duration_s (a procedure) or start_s and end_s"};
    step.start = rig.time + (moves(rig, next) ? text.move_s.value_or(default_move_s) : 0);
    step.end = step.start + *text.duration_s;
  }

  constexpr double latest = 4.6e9;  // s, as of start_s and end_s
  if (!(std::abs(step.end) <= latest))
    return StepProblem{"kind", fmt::format("{} ends {:g} s after the begin; expected at most {:g}", to_string(text.kind), step.end, latest)};

  step.kind = text.kind;
  step.recording = recording;
  for (std::size_t a = 0; a < 3; ++a) step.angles[a] = next.angles_deg[a] * unit::deg;
  if (text.kind == StepKind::rotate) {
    step.axis = text.axis;
    step.angle = text.angle_deg * unit::deg;
    next.angles_deg[static_cast<std::size_t>(text.axis)] += text.angle_deg;
  }
  step.rate = text.rate_dps * unit::deg;
  if (text.kind != StepKind::rotate) step.mount = next.mount;
  step.radius = text.radius_m;
  step.temperature = next.temperature;
  next.time = step.end;
  rig = next;
  return std::nullopt;
}

}  // namespace imulab::session_io
