#include "imulab/estimate/table_observations.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/units.hpp"
#include "imulab/estimate/rest.hpp"
#include "imulab/recording/rest_detection.hpp"
#include "imulab/recording/turn.hpp"
#include "imulab/rig/rig_errors.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace imulab {

namespace {

constexpr double guard_sigmas = 5;  // of the declared timing: a hold's ends that a late or early turn may reach
constexpr double settling = 1;      // s: so much of the rests around a turn goes into its sum; more would add their noise

double start_of(const Recording& r, std::size_t i, bool increment) { return r.time_s(i) - r.interval(i, increment); }

/// The samples whose intervals lie inside [begin, end].
Range inside(const Recording& r, double begin, double end) {
  const double rounding = 1e-3 * r.interval_s;
  const auto after = [&](double s) {
    return static_cast<std::size_t>(std::upper_bound(r.time_ns.begin(), r.time_ns.end(), static_cast<std::int64_t>(std::llround(1e9 * s))) -
                                    r.time_ns.begin());
  };
  std::size_t first = after(begin);
  while (first < r.size() && start_of(r, first, r.gyro_increment) < begin - rounding) ++first;
  return {first, std::max(first, after(end + rounding))};
}

/// The longest stretch of these samples without gaps and saturated ones.
Range longest_piece(const Recording& r, const Range& range) {
  Range longest;
  if (range.size() == 0) return longest;
  for (const Range& piece : without_interruptions(r, range))
    if (piece.size() > longest.size()) longest = piece;
  return longest;
}

std::size_t saturated_in(const Recording& r, const Range& range) {
  const auto first = std::lower_bound(r.saturated.begin(), r.saturated.end(), range.begin);
  return static_cast<std::size_t>(std::lower_bound(first, r.saturated.end(), range.end) - first);
}

/// The samples that cover [begin, end]; empty where the recording does not, or is interrupted.
Range covering(const Recording& r, double begin, double end) {
  const double rounding = 1e-3 * r.interval_s;
  Range range;
  range.begin = static_cast<std::size_t>(
      std::upper_bound(r.time_ns.begin(), r.time_ns.end(), static_cast<std::int64_t>(std::llround(1e9 * (begin + rounding)))) - r.time_ns.begin());
  range.end =
      static_cast<std::size_t>(std::lower_bound(r.time_ns.begin(), r.time_ns.end(), static_cast<std::int64_t>(std::llround(1e9 * (end - rounding)))) -
                               r.time_ns.begin()) +
      1;
  if (range.begin >= r.size() || range.end > r.size() || start_of(r, range.begin, r.gyro_increment) > begin + rounding) return {};
  const auto pieces = without_interruptions(r, range);
  return pieces.size() == 1 && pieces.front() == range ? range : Range{};
}

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

/// Throws Error where a turn cannot have this angle and rate in its time. Recorded times are taken with the timing's tolerance, and one per cent.
void expect_possible(const Step& step, std::size_t k, const std::vector<Step>& steps, double guard) {
  const double available = step.end - step.start, cruise = std::abs(step.angle) / step.rate, tolerance = std::max({guard, 0.01 * available, 1e-3});
  const double shortest = step.acceleration ? turn_duration(step.angle, step.rate, *step.acceleration) : cruise;
  const bool too_short = shortest > available + tolerance, too_long = !step.acceleration && 2 * cruise < available - tolerance;
  if (too_short || too_long)
    throw Error(fmt::format("{}: {:g} deg at {:g} deg/s take {:.5g} s{}, but the step lasts {:.5g} s", describe_step(steps, k), step.angle / unit::deg,
                            step.rate / unit::deg, too_short ? shortest : 2 * cruise, too_long ? " at most" : "", available));
}

}  // namespace

Eigen::VectorXd TableObservations::values() const {
  Eigen::VectorXd v(static_cast<Eigen::Index>(6 * holds.size() + 3 * turns.size()));
  Eigen::Index row = 0;
  for (const HoldObservation& hold : holds) {
    v.segment<3>(row) = hold.accel;
    v.segment<3>(row + 3) = hold.gyro;
    row += 6;
  }
  for (const TurnObservation& turn : turns) {
    v.segment<3>(row) = turn.sum;
    row += 3;
  }
  return v;
}

void TableObservations::set_values(const Eigen::VectorXd& v) {
  Eigen::Index row = 0;
  for (HoldObservation& hold : holds) {
    hold.accel = v.segment<3>(row);
    hold.gyro = v.segment<3>(row + 3);
    row += 6;
  }
  for (TurnObservation& turn : turns) {
    turn.sum = v.segment<3>(row);
    row += 3;
  }
}

std::string describe_step(const std::vector<Step>& steps, std::size_t index) {
  return fmt::format("step {} ({} at {:g} s)", index + 1, to_string(steps[index].kind), steps[index].start);
}

const RigDeclaration& turntable_of(const Session& session, const std::string& recording) {
  std::string name;
  for (const RecordingSource& source : session.recordings)
    if (source.file == recording) name = source.rig;
  for (const RigDeclaration& rig : session.rigs) {
    if (!name.empty() && rig.name != name) continue;
    if (rig.kind == RigKind::turntable) return rig;
    throw Error(fmt::format("{}: [rig] kind = \"{}\": \"turntable\" was expected by the method turntable", session.file, to_string(rig.kind)));
  }
  throw Error(session.file + ": [rig]: the method turntable needs the table's declared accuracy; kind = \"turntable\" was expected");
}

TableObservations planned_observations(const std::vector<Step>& steps, double guard) {
  TableObservations plan;
  plan.steps = steps;
  const std::vector<Command> commands = commands_of(steps);
  for (std::size_t k = 0; k < steps.size(); ++k) {
    const Step& step = steps[k];
    if (step.kind == StepKind::spin) throw Error(describe_step(steps, k) + ": a turntable's steps are hold and rotate");
    if (step.end <= step.start) throw Error(describe_step(steps, k) + ": an end_s after start_s was expected");
    if (k > 0 && step.start < steps[k - 1].end - 1e-9) throw Error(describe_step(steps, k) + ": begins before the step before it has ended");
    if (step.kind == StepKind::hold) {
      const double cut = std::min(guard, 0.25 * (step.end - step.start));
      plan.holds.push_back({k, step.start + cut, step.end - cut});
      continue;
    }
    if (!(std::abs(step.angle) > 0) || !(step.rate > 0))
      throw Error(describe_step(steps, k) + ": angle_deg other than 0 and rate_dps above 0 were expected");
    expect_possible(step, k, steps, guard);
    const auto [before, after] = rest_around(steps, commands, k);
    const double reach = std::max(guard, settling);
    const TurnObservation turn{k, std::max(0.5 * (before + step.start), step.start - reach), std::min(0.5 * (step.end + after), step.end + reach)};
    // A late turn ends outside its step, and makes one that follows without a rest begin late: by an amount that no sum tells apart.
    const bool follows_a_turn = k > 0 && steps[k - 1].kind == StepKind::rotate && before == step.start;
    if (guard > 0 && (turn.end < step.end + guard || follows_a_turn)) {
      plan.warnings.push_back(fmt::format("{}: no rest of {:.3g} s {} it, so where a turn ends, given its timing, is not known: left out",
                                          describe_step(steps, k), 2 * guard, follows_a_turn ? "before" : "after"));
      continue;
    }
    plan.turns.push_back(turn);
  }
  return plan;
}

TableObservations planned_observations(const std::vector<Step>& steps, const RigDeclaration& rig) {
  return planned_observations(steps, guard_sigmas * rig.timing.value);
}

TableObservations planned_observations(const Session& session, const std::string& recording) {
  const RigDeclaration& rig = turntable_of(session, recording);
  RecordingSource source;
  source.file = recording;
  source.rig = rig.name;
  const std::vector<Step> steps = steps_of(session, source);
  if (steps.empty()) throw Error(session.file + ": [[step]]: what the table does was expected");
  return planned_observations(steps, rig);
}

TableObservations observe(const Recording& recording, const Session& session) {
  TableObservations seen = planned_observations(session, recording.name);
  const std::vector<Step>& steps = seen.steps;
  std::vector<Rest> rests;
  for (HoldObservation& hold : seen.holds) {
    const Range all = inside(recording, hold.begin, hold.end), range = longest_piece(recording, all);
    const std::size_t at_limit = saturated_in(recording, all);
    if (range.size() < 2 || 100 * at_limit > all.size()) {  // of a hold near a limit the samples that remain are chosen by their value
      seen.warnings.push_back(describe_step(steps, hold.step) +
                              (at_limit > 0 ? fmt::format(": {} of {} samples are saturated, left out", at_limit, all.size()) : ": no samples, left out"));
      hold.begin = hold.end;
      continue;
    }
    rests.push_back(summarize_rests(recording, {range}).front());
    hold.begin = start_of(recording, range.begin, recording.gyro_increment);
    hold.end = recording.time_s(range.end - 1);
    hold.accel = rests.back().accel;
    hold.gyro = rests.back().gyro;
  }
  for (TurnObservation& turn : seen.turns) {
    const Range range = covering(recording, turn.begin, turn.end);
    turn.begin = turn.end = 0;
    if (range.size() == 0) {
      seen.warnings.push_back(describe_step(steps, turn.step) + ": the recording is interrupted during this turn or does not cover it, left out");
      continue;
    }
    turn.begin = start_of(recording, range.begin, recording.gyro_increment);
    turn.end = recording.time_s(range.end - 1);
    for (std::size_t i = range.begin; i < range.end; ++i)
      for (std::size_t j = 0; j < 3; ++j)
        turn.sum[static_cast<Eigen::Index>(j)] += recording.gyro[j][i] * recording.interval(i, recording.gyro_increment);
  }
  std::erase_if(seen.holds, [](const HoldObservation& hold) { return hold.end <= hold.begin; });
  std::erase_if(seen.turns, [](const TurnObservation& turn) { return turn.end <= turn.begin; });
  if (seen.holds.empty() && seen.turns.empty())
    throw Unsupported(recording.name + ": no samples in the session's steps: do their times belong to this recording's clock (time.zero)?");

  std::size_t samples = 0;
  for (const Rest& rest : rests) samples += rest.range.size();
  if (samples >= rests.size() + 30) {  // 30 degrees of freedom: the noise to 13 %
    const SampleNoise noise = measure_noise(recording, rests);
    seen.accel_density = noise.accel * std::sqrt(recording.interval_s);
    seen.gyro_density = noise.gyro * std::sqrt(recording.interval_s);
    seen.noise_measured = true;
  }
  seen.accel_unit = recording.accel_unit;
  seen.gyro_unit = recording.gyro_unit;
  seen.notes.push_back(fmt::format("{} holds and {} turns of {} steps were used", seen.holds.size(), seen.turns.size(), steps.size()));
  return seen;
}

}  // namespace imulab
