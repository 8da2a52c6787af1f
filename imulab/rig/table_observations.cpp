#include "imulab/rig/table_observations.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/recording/pieces.hpp"
#include "imulab/recording/rest_means.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace imulab::rig {

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
  seen.accel_unit = recording.accel_unit;
  seen.gyro_unit = recording.gyro_unit;
  seen.interval_s = recording.interval_s;
  seen.notes.push_back(
      fmt::format("{} holds and {} turns of {} steps were used", seen.parts.holds.size(), seen.parts.turns.size(), plan.steps.size()));
  seen.parts.steps = plan.steps;
  return seen;
}

}  // namespace imulab::rig
