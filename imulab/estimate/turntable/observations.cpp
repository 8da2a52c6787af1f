#include "imulab/estimate/turntable/observations.hpp"

#include "imulab/core/error.hpp"
#include "imulab/estimate/kernel/rest_means.hpp"
#include "imulab/recording/rest_detection.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace imulab::turntable {

namespace {

double start_of(const Recording& r, std::size_t i, bool increment) { return r.time_s(i) - r.interval(i, increment); }

/// The longest stretch of these samples without gaps and saturated ones.
Range longest_piece(const Recording& r, const Range& range) {
  Range longest;
  if (range.size() == 0) return longest;
  for (const Range& piece : without_interruptions(r, range))
    if (piece.size() > longest.size()) longest = piece;
  return longest;
}

/// The samples that cover [begin, end]; empty where the recording does not, or is interrupted.
Range covering(const Recording& r, double begin, double end) {
  const double rounding = 1e-3 * r.interval_s;
  const auto ns = [](double s) { return static_cast<std::int64_t>(std::llround(1e9 * s)); };
  const auto first = std::upper_bound(r.time_ns.begin(), r.time_ns.end(), ns(begin + rounding));
  const auto last = std::lower_bound(r.time_ns.begin(), r.time_ns.end(), ns(end - rounding));
  const Range range{static_cast<std::size_t>(first - r.time_ns.begin()), static_cast<std::size_t>(last - r.time_ns.begin()) + 1};
  if (range.begin >= r.size() || range.end > r.size() || start_of(r, range.begin, r.gyro_increment) > begin + rounding) return {};
  const auto pieces = without_interruptions(r, range);
  return pieces.size() == 1 && pieces.front() == range ? range : Range{};
}

}  // namespace

const RigDeclaration& turntable_of(const Session& session, const std::string& recording) {
  const RigDeclaration* const rig = session.rig_of(session.source_of(recording));
  if (rig == nullptr) throw Error(session.file + ": no rig; the method turntable expects the declared accuracy of a turntable");
  if (rig->kind != RigKind::turntable)
    throw Error(fmt::format("{}: the rig is of kind \"{}\"; the method turntable expects \"turntable\"", session.file, to_string(rig->kind)));
  return *rig;
}

TablePlan parts_of(const Session& session, const std::string& recording) {
  const RigDeclaration& rig = turntable_of(session, recording);
  const std::vector<Step> steps = session.steps_of(session.source_of(recording));
  if (steps.empty()) throw Error(session.file + ": no steps; expected what the table does");
  return table_plan(steps, rig);
}

Observations observe(const Recording& recording, const Session& session) {
  const TablePlan plan = parts_of(session, recording.name);
  const auto name = [&](const TablePart& part) { return step_name(plan.steps[part.step], part.step); };
  Observations seen;
  seen.warnings = plan.warnings;
  std::vector<kernel::Rest> rests;
  std::vector<double> readings;
  const auto use = [&](TablePart part, const Range& range, std::vector<TablePart>& parts) {
    part.begin = start_of(recording, range.begin, recording.gyro_increment);
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
    rests.push_back(kernel::summarize_rests(recording, {range}).front());
    use(hold, range, seen.parts.holds);
    readings.insert(readings.end(), rests.back().accel.begin(), rests.back().accel.end());
    readings.insert(readings.end(), rests.back().gyro.begin(), rests.back().gyro.end());
  }
  for (const TablePart& turn : plan.turns) {
    const Range range = covering(recording, turn.begin, turn.end);
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

  std::size_t samples = 0;
  for (const kernel::Rest& rest : rests) samples += rest.range.size();
  seen.noise_measured = samples >= rests.size() + 30;  // 30 degrees of freedom: the noise to 13 %
  if (seen.noise_measured) {
    const kernel::SampleNoise noise = kernel::measure_noise(recording, rests);
    seen.accel_density = noise.accel * std::sqrt(recording.interval_s);
    seen.gyro_density = noise.gyro * std::sqrt(recording.interval_s);
  }
  seen.accel_unit = recording.accel_unit;
  seen.gyro_unit = recording.gyro_unit;
  seen.notes.push_back(
      fmt::format("{} holds and {} turns of {} steps were used", seen.parts.holds.size(), seen.parts.turns.size(), plan.steps.size()));
  seen.parts.steps = plan.steps;
  return seen;
}

}  // namespace imulab::turntable
