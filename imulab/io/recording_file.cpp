#include "imulab/io/recording_file.hpp"

#include "imulab/core/error.hpp"
#include "imulab/io/decimal.hpp"
#include "imulab/io/recording_columns.hpp"
#include "imulab/io/recording_parts.hpp"
#include "imulab/io/session_file.hpp"
#include "imulab/recording/stamps.hpp"
#include "imulab/rig/rig_errors.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

namespace imulab {
namespace {

/// Oscillators agree to 1e-4 and a quoted rate is often rounded by a percent, while a mistaken one (unit, decimation, another logger setting)
/// is off by a tenth or more: 2 % parts them.
constexpr double rate_tolerance = 0.02;

bool agree(double a, double b) { return std::abs(a - b) <= rate_tolerance * b; }

double median_interval_s(const TimedTable& table) {
  if (table.time_ns.size() < 2) return 0;
  std::vector<std::int64_t> differences(table.time_ns.size() - 1);
  for (std::size_t i = 0; i < differences.size(); ++i) differences[i] = table.time_ns[i + 1] - table.time_ns[i];
  const auto middle = differences.begin() + static_cast<std::ptrdiff_t>(differences.size() / 2);
  std::nth_element(differences.begin(), middle, differences.end());
  if (differences.size() % 2 == 1) return 1e-9 * static_cast<double>(*middle);
  return 0.5e-9 * (static_cast<double>(*middle) + static_cast<double>(*std::max_element(differences.begin(), middle)));
}

/// Mean of the differences that are no gaps.
double mean_interval_s(const TimedTable& table, double median_s) {
  double sum = 0, count = 0;
  for (std::size_t i = 1; i < table.time_ns.size(); ++i) {
    const auto step = static_cast<double>(table.time_ns[i] - table.time_ns[i - 1]);
    if (step <= 1.5e9 * median_s) sum += step, ++count;
  }
  return 1e-9 * sum / count;
}

/// Declared, or the stamps' median. Coarse stamps (400 Hz in whole milliseconds) have a wrong median but a right mean: a declared rate is
/// contradicted where both differ from it.
double nominal_interval_s(const TimedTable& table, const RecordingSource& source, std::vector<std::string>& warnings) {
  if (table.time_ns.size() < 2) {
    if (source.rate_hz) return 1 / *source.rate_hz;
    throw Error(fmt::format("{}: has one row, expected at least two (or rate_hz in the session)", table.file));
  }
  const double median = median_interval_s(table), mean = mean_interval_s(table, median);
  if (source.rate_hz) {
    const double declared = 1 / *source.rate_hz;
    if (agree(median, declared) || agree(mean, declared)) return declared;
    throw Error(fmt::format("{}: rate_hz = {} is declared, but the stamps say {:.6g} Hz (median difference {:.6g} s), expected within 2 %",
                            table.file, *source.rate_hz, 1 / median, median));
  }
  if (!agree(median, mean))
    warnings.push_back(
        fmt::format("{}: the stamps' differences are uneven (median {:.6g} s, mean {:.6g} s); the median is taken as the nominal interval, "
                    "which scales increments: declare rate_hz",
                    table.file, median, mean));
  return median;
}

/// A late stamp, as a busy computer gives it, is no gap: the stamps around it stand where they did. Four rows before and four from i on see a single
/// late one, also near a gap; sixteen see through stamps that all scatter.
bool rows_are_missing(const TimedTable& table, std::size_t i, double interval_s) {
  constexpr std::size_t around = 4;
  const auto mean_phase_ns = [&](std::size_t begin, std::size_t end) {
    double sum = 0;
    for (std::size_t k = begin; k < end; ++k)
      sum += static_cast<double>(table.time_ns[k] - table.time_ns[i]) - 1e9 * interval_s * (static_cast<double>(k) - static_cast<double>(i));
    return sum / static_cast<double>(end - begin);
  };
  const double later_ns = mean_phase_ns(i, std::min(i + around, table.time_ns.size())) - mean_phase_ns(i - std::min(i, around), i);
  return later_ns > 0.5e9 * interval_s && clock_step(table.time_ns, i, interval_s, 0, table.time_ns.size()) > 0.5;
}

/// Nothing is missed where a recording stops between two of its steps: whoever records point by point leaves out the way from one to the next.
bool between_steps(std::span<const Step> steps, double begin_s, double end_s, double interval_s) {
  const auto next = std::partition_point(steps.begin(), steps.end(), [&](const Step& step) { return step.end <= begin_s + interval_s; });
  return next != steps.begin() && next != steps.end() && next->start >= end_s - interval_s;
}

/// Warns of those that the steps do not explain.
std::vector<std::size_t> find_gaps(const TimedTable& table, double interval_s, std::span<const Step> steps, std::vector<std::string>& warnings) {
  const double limit_ns = 1.5e9 * interval_s, clock_s = clock_interval(table.time_ns, interval_s);
  std::vector<std::size_t> gaps;
  std::size_t unexplained = 0, where = 0;
  std::int64_t largest = 0;
  for (std::size_t i = 1; i < table.time_ns.size(); ++i) {
    const std::int64_t step = table.time_ns[i] - table.time_ns[i - 1];
    if (static_cast<double>(step) <= limit_ns || !rows_are_missing(table, i, clock_s)) continue;
    gaps.push_back(i);
    if (between_steps(steps, 1e-9 * static_cast<double>(table.time_ns[i - 1]), 1e-9 * static_cast<double>(table.time_ns[i]) - interval_s, interval_s))
      continue;
    ++unexplained;
    if (step > largest) largest = step, where = i;
  }
  if (unexplained > 0)
    warnings.push_back(
        fmt::format("{}: {} gap{} in time (more than 1.5 of the nominal {:.6g} s), the largest of {} s before {} s (line {}); what "
                    "moved inside a gap is not seen",
                    table.file, unexplained, unexplained == 1 ? "" : "s", interval_s, seconds_text(largest), seconds_text(table.time_ns[where]),
                    table.lines[where]));
  return gaps;
}

void warn_of_saturated(const std::vector<std::size_t>& saturated, const TimedTable& table, std::vector<std::string>& warnings) {
  if (saturated.empty()) return;
  warnings.push_back(fmt::format("{}: {} sample{} at a limit, the first at {} s (line {}): the true reading lies beyond, such samples are set aside",
                                 table.file, saturated.size(), saturated.size() == 1 ? "" : "s", seconds_text(table.time_ns[saturated[0]]),
                                 table.lines[saturated[0]]));
}

}  // namespace

RecordingReading read_recording(const Session& session, const RecordingSource& source) {
  RecordingParts parts = read_parts(session, source);
  RecordingReading reading;
  TimedTable& reference = parts.tables[parts.gyro.table];
  for (const TimedTable& table : parts.tables)
    if (table.repeated > 0)
      reading.warnings.push_back(
          fmt::format("{}: {} row{} equal to the row before dropped", table.file, table.repeated, table.repeated == 1 ? "" : "s"));

  const double interval_s = nominal_interval_s(reference, source, reading.warnings);
  for (const TimedTable& table : parts.tables) {
    const double median = median_interval_s(table);
    if (&table != &reference && median > 0 && !agree(median, interval_s))
      throw Error(
          fmt::format("{}: rows every {:.6g} s, expected every {:.6g} s (within 2 %) as in {}", table.file, median, interval_s, reference.file));
  }
  match_rows(parts, interval_s, reading.warnings);
  std::vector<std::size_t> gaps = find_gaps(reference, interval_s, steps_of(session, source), reading.warnings);

  reading.recording = recording_of(source, interval_s,
                                   {take_columns(parts, parts.gyro), take_columns(parts, parts.accel), take_columns(parts, parts.gyro_temperature),
                                    take_columns(parts, parts.accel_temperature)});
  warn_of_saturated(reading.recording.saturated, reference, reading.warnings);
  reading.recording.gaps = std::move(gaps);
  reading.recording.time_ns = std::move(reference.time_ns);
  return reading;
}

}  // namespace imulab
