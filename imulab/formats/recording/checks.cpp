#include "imulab/formats/recording/checks.hpp"

#include "imulab/core/error.hpp"
#include "imulab/formats/text/decimal.hpp"
#include "imulab/recording/stamps.hpp"
#include "imulab/recording/validate.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <string_view>

namespace imulab::recording_io {

namespace {

/// Rounding to less of an interval than this moves no nominal interval by as much as two quoted rates may differ.
constexpr double said_of_rounding = 0.02;

/// No gap is reported where a recording stops between two of its steps: who records point by point leaves out the time between them.
bool between_steps(std::span<const Step> steps, double begin_s, double end_s, double interval_s) {
  const auto next = std::partition_point(steps.begin(), steps.end(), [&](const Step& step) { return step.end <= begin_s + interval_s; });
  return next != steps.begin() && next != steps.end() && next->start >= end_s - interval_s;
}

}  // namespace

double nominal_interval_s(std::span<const std::int64_t> time_ns, const std::string& file, const RecordingSource& source,
                          std::vector<std::string>& warnings) {
  if (time_ns.size() < 2) {
    if (source.rate_hz) return 1 / *source.rate_hz;
    throw Error(fmt::format("{}: has one row; expected at least two (or rate_hz in the session)", file));
  }
  const StampIntervals stamps = stamp_intervals(time_ns);
  if (source.rate_hz) {
    const double declared = 1 / *source.rate_hz;
    if (stamps.allow(declared)) return declared;
    throw Error(fmt::format("{}: rate_hz = {} is declared, but the stamps give {:.6g} Hz (median difference {:.6g} s); expected agreement within 2 %",
                            file, *source.rate_hz, 1 / stamps.median, stamps.median));
  }
  if (stamps.rounded_s && *stamps.rounded_s > said_of_rounding * stamps.median)
    warnings.push_back(fmt::format("{}: the stamps are rounded to {:g} s; an even clock of {:.4g} s ({:.4g} Hz) fits them, and gives its interval",
                                   file, *stamps.rounded_s, stamps.median, 1 / stamps.median));
  if (!same_interval(stamps.median, stamps.mean))
    warnings.push_back(
        fmt::format("{}: the stamps' differences are uneven (median {:.6g} s, mean {:.6g} s); the median is taken as the nominal interval, "
                    "which scales increments: declare rate_hz",
                    file, stamps.median, stamps.mean));
  return stamps.median;
}

void warn_of_gaps(const RecordingView& recording, const TimedTable& table, std::span<const Step> steps, std::vector<std::string>& warnings) {
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

void warn_of_saturated(const RecordingView& recording, const TimedTable& table, std::vector<std::string>& warnings) {
  const std::span<const std::size_t> saturated = recording.saturated;
  if (saturated.empty()) return;
  warnings.push_back(fmt::format("{}: {} sample{} at a limit, the first at {} s ({}): the true reading lies beyond, such samples are not used",
                                 table.file, saturated.size(), saturated.size() == 1 ? "" : "s", text::seconds_text(recording.time_ns[saturated[0]]),
                                 table.place(saturated[0])));
}

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

void expect_possible_temperature(const std::optional<ThermalSource>& source, const Columns3& readings, const TimedTable& table) {
  if (!source || source->unit == "raw") return;
  constexpr double least_degC = -273.15, most_degC = 1000;  // absolute zero; every IMU has melted
  const double zero = source->unit == "K" ? -least_degC : 0;
  for (const auto& column : readings)
    for (std::size_t i = 0; i < column.size(); ++i)
      if (!(column[i] >= least_degC + zero && column[i] <= most_degC + zero))
        throw Error(fmt::format("{}: {}: the temperature is {:g} {}; expected {:g} to {:g}, or unit = \"raw\"", table.file, table.place(i), column[i],
                                source->unit, least_degC + zero, most_degC + zero));
}

void warn_of_rate(const RecordingSource& source, const RecordingView& recording, const TimedTable& table, std::vector<std::string>& warnings) {
  if (!source.rate_hz || (source.gyro.output != Output::increment && source.accel.output != Output::increment)) return;
  const double by_stamps = 1 / clock_interval(recording.time_ns, recording.interval_s), error = *source.rate_hz / by_stamps - 1;
  if (std::abs(error) > 1e-3)  // oscillators agree to 1e-4
    warnings.push_back(
        fmt::format("{}: rate_hz = {} is declared, the stamps give {:.6g} Hz; increments are divided by the declared interval, so scales "
                    "are {:.2g} % off if the stamps are right",
                    table.file, *source.rate_hz, by_stamps, 100 * error));
}

void warn_of_repeated(const TimedTable& table, std::vector<std::string>& warnings) {
  if (table.repeated > 0)
    warnings.push_back(fmt::format("{}: {} row{} equal to the row before dropped", table.file, table.repeated, table.repeated == 1 ? "" : "s"));
}

}  // namespace imulab::recording_io
