#include "imulab/rig/table_plan.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/units.hpp"
#include "imulab/recording/turn.hpp"
#include "imulab/rig/rig_errors.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace imulab::rig {

namespace {

constexpr double guard_sigmas = 5;  // of the declared timing: the ends of a hold that a late or early turn may reach
constexpr double settling = 1;      // s: this much of the rests around a turn goes into its sum; more would add their noise

/// The rest around a turn: from `before` to its start and from its end to `after`. Equal times: there is none.
struct RestAround {
  double before, after;
};

RestAround rest_around(const std::vector<Step>& steps, const std::vector<Command>& commands, std::size_t k) {
  RestAround rest{steps[k].start, steps[k].end};
  if (k > 0) rest.before = steps[k - 1].kind == StepKind::hold ? steps[k - 1].start : steps[k - 1].end;
  if (k + 1 < steps.size()) {
    const auto& moves = commands[k + 1].moves;
    if (steps[k + 1].kind == StepKind::rotate)
      rest.after = steps[k + 1].start;
    else if (std::none_of(moves.begin(), moves.end(), [](bool m) { return m; }))
      rest.after = steps[k + 1].end;
  }
  return rest;
}

/// Throws Error where a turn of this angle and rate does not fit into its time. Recorded times have the timing's tolerance, and one percent.
void expect_possible(const Step& step, std::size_t k, double guard) {
  const double available = step.end - step.start, cruise = std::abs(step.angle) / step.rate, tolerance = std::max({guard, 0.01 * available, 1e-3});
  const double shortest = step.acceleration ? turn_duration(step.angle, step.rate, *step.acceleration) : cruise;
  const bool too_short = shortest > available + tolerance, too_long = !step.acceleration && 2 * cruise < available - tolerance;
  if (too_short || too_long)
    throw Error(fmt::format("{}: {:g} deg at {:g} deg/s take {:.5g} s{}, but the step lasts {:.5g} s", step_name(step, k), step.angle / unit::deg,
                            step.rate / unit::deg, too_short ? shortest : 2 * cruise, too_long ? " at most" : "", available));
}

}  // namespace

TablePlan table_plan(const std::vector<Step>& steps, double guard) {
  TablePlan plan;
  plan.steps = steps;
  const std::vector<Command> commands = commands_of(steps);
  for (std::size_t k = 0; k < steps.size(); ++k) {
    const Step& step = steps[k];
    if (step.kind == StepKind::spin) throw Error(step_name(step, k) + ": a turntable does not spin; expected hold or rotate");
    if (step.end <= step.start) throw Error(step_name(step, k) + ": its end is not after its start; expected a later end");
    if (k > 0 && step.start < steps[k - 1].end - 1e-9)
      throw Error(step_name(step, k) + ": begins before the end of the previous step; expected a later start");
    if (step.kind == StepKind::hold) {
      const double cut = std::min(guard, 0.25 * (step.end - step.start));
      plan.holds.push_back({k, step.start + cut, step.end - cut});
      continue;
    }
    if (!(std::abs(step.angle) > 0) || !(step.rate > 0)) throw Error(step_name(step, k) + ": expected an angle other than 0 and a rate above 0");
    expect_possible(step, k, guard);
    const auto [before, after] = rest_around(steps, commands, k);
    const double reach = std::max(guard, settling);
    const TablePart turn{k, std::max(0.5 * (before + step.start), step.start - reach), std::min(0.5 * (step.end + after), step.end + reach)};
    // A late turn ends outside its step, and delays one that follows without a rest, by an amount that no sum can separate.
    const bool follows_a_turn = k > 0 && steps[k - 1].kind == StepKind::rotate && before == step.start;
    if (guard > 0 && (turn.end < step.end + guard || follows_a_turn)) {
      plan.warnings.push_back(fmt::format("{}: no rest of {:.3g} s {} it; with the declared timing the end of the turn is not known; it is left out",
                                          step_name(step, k), 2 * guard, follows_a_turn ? "before" : "after"));
      continue;
    }
    plan.turns.push_back(turn);
  }
  return plan;
}

TablePlan table_plan(const std::vector<Step>& steps, const RigDeclaration& rig) { return table_plan(steps, guard_sigmas * rig.timing.value); }

const RigDeclaration& turntable_of(const Session& session, const std::string& recording) {
  const RigDeclaration* const rig = session.rig_of(session.source_of(recording));
  if (rig == nullptr) throw Error(session.file + ": no rig; the method turntable expects the declared accuracy of a turntable");
  if (rig->kind != RigKind::turntable)
    throw Error(fmt::format("{}: the rig is of kind \"{}\"; the method turntable expects \"turntable\"", session.file, to_string(rig->kind)));
  return *rig;
}

TablePlan table_plan(const Session& session, const std::string& recording) {
  const RigDeclaration& rig = turntable_of(session, recording);
  const std::vector<Step> steps = session.steps_of(session.source_of(recording));
  if (steps.empty()) throw Error(session.file + ": no steps; expected what the table does");
  return table_plan(steps, rig);
}

}  // namespace imulab::rig
