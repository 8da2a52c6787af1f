#include "imulab/core/error.hpp"
#include "imulab/io/recording/file.hpp"
#include "imulab/io/recording/parts.hpp"
#include "imulab/io/session/file.hpp"
#include "imulab/io/text/decimal.hpp"
#include "imulab/recording/make_recording.hpp"
#include "imulab/recording/stamps.hpp"
#include "imulab/recording/unit_names.hpp"
#include "imulab/recording/validate.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

namespace imulab {
namespace {

using namespace recording_io;

/// Declared, or the stamps' median.
double nominal_interval_s(const TimedTable& table, const RecordingSource& source, std::vector<std::string>& warnings) {
  if (table.time_ns.size() < 2) {
    if (source.rate_hz) return 1 / *source.rate_hz;
    throw Error(fmt::format("{}: has one row; expected at least two (or rate_hz in the session)", table.file));
  }
  const StampIntervals stamps = stamp_intervals(table.time_ns);
  if (source.rate_hz) {
    const double declared = 1 / *source.rate_hz;
    if (stamps.allow(declared)) return declared;
    throw Error(fmt::format("{}: rate_hz = {} is declared, but the stamps give {:.6g} Hz (median difference {:.6g} s); expected agreement within 2 %",
                            table.file, *source.rate_hz, 1 / stamps.median, stamps.median));
  }
  if (!same_interval(stamps.median, stamps.mean))
    warnings.push_back(
        fmt::format("{}: the stamps' differences are uneven (median {:.6g} s, mean {:.6g} s); the median is taken as the nominal interval, "
                    "which scales increments: declare rate_hz",
                    table.file, stamps.median, stamps.mean));
  return stamps.median;
}

/// No gap is reported where a recording stops between two of its steps: who records point by point leaves out the time between them.
bool between_steps(std::span<const Step> steps, double begin_s, double end_s, double interval_s) {
  const auto next = std::partition_point(steps.begin(), steps.end(), [&](const Step& step) { return step.end <= begin_s + interval_s; });
  return next != steps.begin() && next != steps.end() && next->start >= end_s - interval_s;
}

/// Warns of the gaps that the steps do not explain.
void warn_of_gaps(const Recording& recording, const TimedTable& table, std::span<const Step> steps, std::vector<std::string>& warnings) {
  const double interval_s = recording.interval_s;
  std::size_t unexplained = 0, where = 0;
  std::int64_t largest = 0;
  for (const std::size_t i : recording.gaps) {
    if (between_steps(steps, recording.time_s(i - 1), recording.time_s(i) - interval_s, interval_s)) continue;
    ++unexplained;
    if (const std::int64_t step = recording.time_ns[i] - recording.time_ns[i - 1]; step > largest) largest = step, where = i;
  }
  if (unexplained > 0)
    warnings.push_back(
        fmt::format("{}: {} gap{} in time (more than 1.5 of the nominal {:.6g} s), the largest of {} s before {} s ({}); what "
                    "moved inside a gap is not seen",
                    table.file, unexplained, unexplained == 1 ? "" : "s", interval_s, text::seconds_text(largest),
                    text::seconds_text(recording.time_ns[where]), table.place(where)));
}

void warn_of_saturated(const Recording& recording, const TimedTable& table, std::vector<std::string>& warnings) {
  const std::vector<std::size_t>& saturated = recording.saturated;
  if (saturated.empty()) return;
  warnings.push_back(fmt::format("{}: {} sample{} at a limit, the first at {} s ({}): the true reading lies beyond, such samples are not used",
                                 table.file, saturated.size(), saturated.size() == 1 ? "" : "s", text::seconds_text(recording.time_ns[saturated[0]]),
                                 table.place(saturated[0])));
}

/// A reading that no sensor gives, named by its line.
void expect_plausible(const Columns3& triad, const ReadingOptions& options, Quantity quantity, double interval_s, const TimedTable& table) {
  const char* const name = quantity == Quantity::gyro ? "gyro" : "accel";
  const std::string_view si = options.unit == "count" ? "count" : quantity == Quantity::gyro ? "rad/s" : "m/s^2";
  const double largest = largest_reading(si) / si_factor(options.unit) * options.counts_per_unit * (options.increment ? interval_s : 1);
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t i = 0; i < triad[axis].size(); ++i)
      if (!(std::abs(triad[axis][i]) <= largest))
        throw Error(fmt::format("{}: {}: {} {} is {:g} {}; expected a reading that a sensor can give", table.file, table.place(i), name, "xyz"[axis],
                                triad[axis][i], options.unit));
}

void expect_above_absolute_zero(const std::optional<ThermalSource>& source, const Columns3& readings, const TimedTable& table) {
  if (!source || source->unit == "raw") return;
  const double zero = source->unit == "K" ? 0 : -273.15;
  for (const auto& column : readings)
    for (std::size_t i = 0; i < column.size(); ++i)
      if (!(column[i] >= zero))
        throw Error(fmt::format("{}: {}: the temperature is {:g} {}; expected one above absolute zero, or unit = \"raw\"", table.file, table.place(i),
                                column[i], source->unit));
}

/// Increments become rates by the declared interval, so a wrong one scales them.
void warn_of_rate(const RecordingSource& source, const Recording& recording, const TimedTable& table, std::vector<std::string>& warnings) {
  if (!source.rate_hz || !(recording.gyro_increment || recording.accel_increment)) return;
  const double by_stamps = 1 / clock_interval(recording.time_ns, recording.interval_s), error = *source.rate_hz / by_stamps - 1;
  if (std::abs(error) > 1e-3)  // oscillators agree to 1e-4
    warnings.push_back(
        fmt::format("{}: rate_hz = {} is declared, the stamps give {:.6g} Hz; increments are divided by the declared interval, so scales "
                    "are {:.2g} % off if the stamps are right",
                    table.file, *source.rate_hz, by_stamps, 100 * error));
}

}  // namespace

RecordingReading read_recording(const Session& session, const RecordingSource& source, const std::vector<RecordingFormat>& formats) {
  RecordingParts parts = read_parts(session, source, formats);
  RecordingReading reading;
  TimedTable& reference = parts.tables[parts.gyro.table];
  for (const TimedTable& table : parts.tables) reading.warnings.insert(reading.warnings.end(), table.warnings.begin(), table.warnings.end());
  for (const TimedTable& table : parts.tables)
    if (table.repeated > 0)
      reading.warnings.push_back(
          fmt::format("{}: {} row{} equal to the row before dropped", table.file, table.repeated, table.repeated == 1 ? "" : "s"));

  const double interval_s = nominal_interval_s(reference, source, reading.warnings);
  join_by_time(parts, interval_s, source.accel.output == Output::increment, reading.warnings);
  match_rows(parts, interval_s, reading.warnings);
  RecordingOptions options = recording_options(source);
  options.interval_s = interval_s;
  options.gyro.temperature = take_columns(parts, parts.gyro_temperature);
  options.accel.temperature = take_columns(parts, parts.accel_temperature);
  Columns3 gyro = three_columns(take_columns(parts, parts.gyro)), accel = three_columns(take_columns(parts, parts.accel));
  expect_plausible(gyro, options.gyro, Quantity::gyro, interval_s, reference);
  expect_plausible(accel, options.accel, Quantity::accel, interval_s, parts.tables[parts.accel.table]);
  reading.recording = make_recording(std::move(reference.time_ns), std::move(gyro), std::move(accel), std::move(options));
  expect_above_absolute_zero(source.gyro_temperature, reading.recording.gyro_temperature, reference);
  expect_above_absolute_zero(source.accel_temperature, reading.recording.accel_temperature, reference);
  warn_of_rate(source, reading.recording, reference, reading.warnings);
  warn_of_gaps(reading.recording, reference, session.steps_of(source), reading.warnings);
  warn_of_saturated(reading.recording, reference, reading.warnings);
  return reading;
}

}  // namespace imulab
