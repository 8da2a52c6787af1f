#include "imulab/rig/table_plan.hpp"

#include "imulab/core/statistics.hpp"
#include "imulab/error.hpp"
#include "imulab/recording/recording_view.hpp"
#include "imulab/recording/rest_means.hpp"
#include "imulab/recording/turn.hpp"
#include "imulab/rig/rig_errors.hpp"
#include "imulab/rig/thermal_scale.hpp"
#include "imulab/units.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace imulab {

namespace {

constexpr double guard_sigmas = 5;  // of the declared timing: the ends of a hold that a late or early turn may reach
constexpr double settling = 1;      // s: this much of the rests around a turn goes into its sum; more would add their noise

/// The rest around a turn: from `before` to its start and from its end to `after`. Equal times: there is none.
struct RestAround {
  double before, after;
};

RestAround rest_around(const std::vector<Step>& steps, const std::vector<AxisCommand>& commands, std::size_t k) {
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
  if (!steps.empty()) plan.begin = steps.front().start, plan.end = steps.back().end;
  const std::vector<AxisCommand> commands = commands_of(steps);
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
    throw Error(fmt::format("{}: the rig is of kind \"{}\"; the method turntable expects \"turntable\"{}", session.file, to_string(rig->kind),
                            rig->kind == RigKind::none ? "; without a rig: --method handheld" : ""));
  return *rig;
}

TablePlan table_plan(const Session& session, const std::string& recording) {
  const RigDeclaration& rig = turntable_of(session, recording);
  const std::vector<Step> steps = session.steps_of(session.source_of(recording));
  if (steps.empty()) throw Error(session.file + ": no steps; expected what the table does");
  return table_plan(steps, rig);
}

namespace {

/// Variance of a hold's mean over that of independent samples: below 1 for quantization, whose errors cancel between samples, above 1 for what lasts
/// longer than a sample. The variance of a mean of n samples is taken as a / n + b / n^2, from samples and from tenths of a hold.
double correlation(const std::vector<double>& column, const std::vector<RestMeans>& rests) {
  std::vector<double> lengths;
  for (const RestMeans& rest : rests) lengths.push_back(static_cast<double>(rest.range.size()));
  const double length = median(lengths);
  const auto block = static_cast<std::size_t>(length / 10);
  if (block < 2) return 1;
  const auto variance = [&](std::size_t size) {  // of means of so many samples, about the hold's; and its degrees of freedom
    double sum = 0, degrees = 0;
    for (const RestMeans& rest : rests) {
      std::vector<double> means;
      for (std::size_t i = rest.range.begin; i + size <= rest.range.end; i += size)
        means.push_back(
            std::accumulate(column.begin() + static_cast<std::ptrdiff_t>(i), column.begin() + static_cast<std::ptrdiff_t>(i + size), 0.0) /
            static_cast<double>(size));
      if (means.size() < 2) continue;
      const double mean = std::accumulate(means.begin(), means.end(), 0.0) / static_cast<double>(means.size());
      for (const double m : means) sum += (m - mean) * (m - mean);
      degrees += static_cast<double>(means.size() - 1);
    }
    return std::pair(sum / degrees, degrees);
  };
  const double n = static_cast<double>(block), of_samples = variance(1).first;
  const auto [of_blocks, degrees] = variance(block);
  const double ratio = of_blocks * n / of_samples;
  // White noise leaves this range once in 400 axes; a dead channel has no ratio.
  if (!(degrees > 0) || !(std::abs(ratio - 1) > 3 * std::sqrt(2 / degrees))) return 1;
  const double b = (1 - ratio) / (1 - 1 / n), a = std::max(0.0, ratio - b / n);
  return a + b / length;
}

/// The noise of the holds' samples, where there are enough.
void measure_densities(TableObservations& seen, const Recording& recording, const std::vector<RestMeans>& rests) {
  std::size_t samples = 0;
  for (const RestMeans& rest : rests) samples += rest.range.size();
  seen.noise_measured = samples >= rests.size() + 30;  // 30 degrees of freedom: the noise to 13 %
  if (seen.noise_measured) {
    const SampleNoise noise = measure_noise(recording, rests);
    seen.accel_density = noise.accel * std::sqrt(recording.interval_s);
    seen.gyro_density = noise.gyro * std::sqrt(recording.interval_s);
    for (std::size_t k = 0; k < 3; ++k) {
      seen.accel_density[static_cast<Eigen::Index>(k)] *= std::sqrt(correlation(recording.accel[k], rests));
      seen.gyro_density[static_cast<Eigen::Index>(k)] *= std::sqrt(correlation(recording.gyro[k], rests));
    }
  }
}

/// The variance of a hold's accelerometers beyond their noise: the declared one, or that of all holds.
void add_shaking(TableObservations& seen, const Recording& recording, const std::vector<RestMeans>& rests, std::optional<double> density) {
  for (std::size_t k = 0; k < rests.size(); ++k)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto i = static_cast<Eigen::Index>(axis);
      double square = 0;
      for (std::size_t n = rests[k].range.begin; n < rests[k].range.end; ++n) square += std::pow(recording.accel[axis][n] - rests[k].accel[i], 2);
      const double noise = std::pow(density.value_or(seen.accel_density[i]), 2) / recording.interval_s;
      seen.parts.holds[k].shaking[i] = square / static_cast<double>(rests[k].range.size() - 1) - noise;
    }
}

void add_warming(TableObservations& seen, const Recording& recording, const Session& session) {
  const std::optional<Thermometer> thermometer = thermometer_of(recording, session.source_of(recording.name));
  if (!thermometer) return;
  for (std::vector<TablePart>* parts : {&seen.parts.holds, &seen.parts.turns})
    for (TablePart& part : *parts) {
      const Range range = recording.samples_in(part.begin, part.end);
      if (range.size() == 0) continue;
      part.warming = 0;
      for (std::size_t n = range.begin; n < range.end; ++n) *part.warming += thermometer->warming(n) / static_cast<double>(range.size());
    }
}

}  // namespace

TableObservations observe(const Recording& recording, const Session& session) {
  const TablePlan plan = table_plan(session, recording.name);
  const auto name = [&](const TablePart& part) { return step_name(plan.steps[part.step], part.step); };
  TableObservations seen;
  seen.warnings = plan.warnings;
  std::vector<RestMeans> rests;
  std::vector<double> readings;
  const auto use = [&](TablePart part, const Range& range, std::vector<TablePart>& parts) {
    part.begin = start_of_sample(recording, range.begin);
    part.end = recording.time_s(range.end - 1);
    parts.push_back(part);
  };
  for (const TablePart& hold : plan.holds) {
    const Range all = recording.samples_in(hold.begin, hold.end), range = longest_piece(recording, all);
    const std::size_t at_limit = recording.saturated_in(all);
    if (range.size() < 2 || 100 * at_limit > all.size()) {  // of a hold near a limit the samples that remain are chosen by their value
      seen.warnings.push_back(
          name(hold) + (at_limit > 0 ? fmt::format(": {} of {} samples are saturated, left out", at_limit, all.size()) : ": no samples, left out"));
      continue;
    }
    rests.push_back(summarize_rests(recording, {range}).front());
    use(hold, range, seen.parts.holds);
    readings.insert(readings.end(), rests.back().accel.begin(), rests.back().accel.end());
    readings.insert(readings.end(), rests.back().gyro.begin(), rests.back().gyro.end());
  }
  for (const TablePart& turn : plan.turns) {
    const Range range = samples_covering(recording, turn.begin, turn.end);
    if (range.size() == 0) {
      seen.warnings.push_back(name(turn) + ": the recording is interrupted during this turn or does not cover it, left out");
      continue;
    }
    use(turn, range, seen.parts.turns);
    for (const std::vector<double>& column : recording.gyro) {
      readings.push_back(0);
      for (std::size_t i = range.begin; i < range.end; ++i) readings.back() += column[i] * recording.interval(i, recording.gyro_increment);
    }
  }
  if (readings.empty()) throw Unsupported(recording.name + ": no samples within the steps; check that the steps' times are on the recording's clock");
  seen.readings = Eigen::Map<const Eigen::VectorXd>(readings.data(), static_cast<Eigen::Index>(readings.size()));

  measure_densities(seen, recording, rests);
  if (recording.accel_unit != "count" && seen.noise_measured) add_shaking(seen, recording, rests, session.imu.accel_noise_density);
  add_warming(seen, recording, session);
  seen.accel_unit = recording.accel_unit;
  seen.gyro_unit = recording.gyro_unit;
  seen.interval_s = recording.interval_s;
  seen.notes.push_back(
      fmt::format("{} holds and {} turns of {} steps were used", seen.parts.holds.size(), seen.parts.turns.size(), plan.steps.size()));
  seen.parts.steps = plan.steps;
  seen.parts.begin = start_of_sample(recording, 0);
  seen.parts.end = recording.time_s(recording.size() - 1);
  return seen;
}

}  // namespace imulab
