#include "imulab/error.hpp"
#include "imulab/recording.hpp"
#include "imulab/recording/clipping.hpp"
#include "imulab/recording/clock.hpp"
#include "imulab/recording/readings.hpp"
#include "imulab/recording/unit_names.hpp"
#include "imulab/recording/validate.hpp"
#include "imulab/session.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

namespace imulab {
namespace {

/// Checks the options of a triad and fills in SI where they name no unit.
void check_options(ReadingOptions& triad, Quantity quantity, const std::string& name) {
  const std::vector<std::string_view> known = unit_names(quantity, triad.increment);
  if (triad.unit.empty()) triad.unit = quantity == Quantity::gyro ? (triad.increment ? "rad" : "rad/s") : (triad.increment ? "m/s" : "m/s^2");
  const std::string_view name_of_unit = unit_name(triad.unit, quantity, triad.increment);
  if (name_of_unit.empty()) throw Error(fmt::format("{}: the unit is \"{}\"; expected one of {}", name, triad.unit, fmt::join(known, ", ")));
  triad.unit = name_of_unit;
  if (!(triad.counts_per_unit > 0 && std::isfinite(triad.counts_per_unit)))
    throw Error(fmt::format("{}: {} counts per unit; expected more than 0", name, triad.counts_per_unit));
  if (triad.unit == "count" && triad.counts_per_unit != 1)
    throw Error(
        fmt::format("{}: {} counts per unit of readings in counts; expected the physical unit that so many counts are", name, triad.counts_per_unit));
  if (triad.axes && !are_body_axes(*triad.axes))
    throw Error(name + ": the axes are no body axes; expected each of the indices 0, 1, 2 once, with the sign 1 or -1");
  if (triad.limits && !((*triad.limits)[0] < (*triad.limits)[1]))
    throw Error(fmt::format("{}: the limits are {} and {}; expected the lower one first", name, (*triad.limits)[0], (*triad.limits)[1]));
  if (const std::size_t columns = triad.temperature.size(); columns != 0 && columns != 1 && columns != 3)
    throw Error(fmt::format("{}: {} temperature columns; expected none, one or three", name, columns));
}

void check_options(RecordingOptions& options) {
  if (options.interval_s && !(*options.interval_s > 0 && std::isfinite(*options.interval_s)))
    throw Error(fmt::format("{}: the interval is {} s; expected a positive number", options.name, *options.interval_s));
  check_options(options.gyro, Quantity::gyro, options.name + ": gyro");
  check_options(options.accel, Quantity::accel, options.name + ": accel");
}

/// Declared, or the stamps' median.
double nominal_interval(const std::vector<std::int64_t>& time_ns, const RecordingOptions& options) {
  if (options.interval_s) return *options.interval_s;
  if (time_ns.size() < 2) throw Error(fmt::format("{}: {} samples; expected at least two, or the interval", options.name, time_ns.size()));
  const StampIntervals stamps = stamp_intervals(time_ns);
  if ((options.gyro.increment || options.accel.increment) && !same_interval(stamps.median, stamps.mean))
    throw Error(fmt::format("{}: the stamps' differences are uneven (median {:.6g} s, mean {:.6g} s); expected the interval, which scales increments",
                            options.name, stamps.median, stamps.mean));
  return stamps.median;
}

/// Marks the samples at or beyond the limits.
void mark_saturated(const Columns3& triad, const ReadingOptions& options, std::vector<bool>& saturated) {
  if (!options.limits) return;
  const auto [low, high] = *options.limits;
  for (const auto& column : triad) {
    saturated.resize(std::max(saturated.size(), column.size()));
    for (std::size_t i = 0; i < column.size(); ++i)
      if (column[i] <= low || column[i] >= high) saturated[i] = true;
  }
}

std::vector<std::size_t> marked(const std::vector<bool>& marks) {
  std::vector<std::size_t> samples;
  for (std::size_t i = 0; i < marks.size(); ++i)
    if (marks[i]) samples.push_back(i);
  return samples;
}

/// Adds the samples of channels that clip although no limits are declared.
void add_clipped(Recording& recording, const RecordingOptions& options) {
  std::vector<bool> saturated(recording.size());
  for (const std::size_t i : recording.saturated) saturated[i] = true;
  for (const auto& [triad, declared] : {std::pair{&recording.gyro, options.gyro.limits}, std::pair{&recording.accel, options.accel.limits}})
    if (!declared)
      for (const auto& channel : *triad)
        for (const std::size_t i : clipped_samples(channel)) saturated[i] = true;
  recording.saturated = marked(saturated);
}

/// Columns along other body axes than x, y, z, as columns along these.
void to_body_axes(Columns3& triad, const ReadingOptions& options) {
  if (!options.axes) return;
  Columns3 body;
  for (std::size_t column = 0; column < 3; ++column) {
    const BodyAxis axis = (*options.axes)[column];
    if (axis.sign < 0)
      for (double& value : triad[column]) value = -value;
    body[static_cast<std::size_t>(axis.index)] = std::move(triad[column]);
  }
  triad = std::move(body);
}

void to_si(Columns3& triad, const ReadingOptions& options, double interval_s) {
  const double factor = si_factor(options.unit) / options.counts_per_unit;
  if (factor == 1 && !options.increment) return;
  for (auto& column : triad)
    for (double& value : column) value = options.increment ? value * factor / interval_s : value * factor;
}

}  // namespace

RecordingOptions recording_options(const RecordingSource& source) {
  const auto triad = [](const TriadSource& from) {
    return ReadingOptions{from.unit, from.counts_per_unit.value_or(1), from.output == Output::increment, from.axes, from.limits, {}};
  };
  return {source.file, source.rate_hz ? std::optional(1 / *source.rate_hz) : std::nullopt, triad(source.gyro), triad(source.accel)};
}

Columns3 three_columns(std::vector<std::vector<double>> columns) {
  if (columns.empty()) return {};
  if (columns.size() == 1) return {columns[0], columns[0], columns[0]};
  return {std::move(columns[0]), std::move(columns[1]), std::move(columns[2])};
}

Recording convert_readings(Columns3 gyro, Columns3 accel, RecordingOptions options) {
  check_options(options);
  Recording recording;
  recording.name = std::move(options.name);
  recording.interval_s = options.interval_s.value_or(0);
  recording.gyro = std::move(gyro);
  recording.accel = std::move(accel);
  recording.gyro_temperature = three_columns(std::move(options.gyro.temperature));
  recording.accel_temperature = three_columns(std::move(options.accel.temperature));
  std::vector<bool> saturated;
  mark_saturated(recording.gyro, options.gyro, saturated);
  mark_saturated(recording.accel, options.accel, saturated);
  recording.saturated = marked(saturated);
  recording.gyro_increment = options.gyro.increment;
  recording.accel_increment = options.accel.increment;
  recording.gyro_unit = options.gyro.unit == "count" ? "count" : "rad/s";
  recording.accel_unit = options.accel.unit == "count" ? "count" : "m/s^2";
  to_body_axes(recording.gyro, options.gyro);
  to_body_axes(recording.accel, options.accel);
  to_si(recording.gyro, options.gyro, recording.interval_s);
  to_si(recording.accel, options.accel, recording.interval_s);
  return recording;
}

void append(Recording& all, const Recording& piece, const Range& samples) {
  const auto add = [&](auto& to, const auto& from) {
    if (!from.empty())
      to.insert(to.end(), from.begin() + static_cast<std::ptrdiff_t>(samples.begin), from.begin() + static_cast<std::ptrdiff_t>(samples.end));
  };
  expect_inside(samples, piece.size(), piece.name);
  const std::size_t before = all.size();
  if (before == 0) {
    all = piece;
    all.time_ns.clear(), all.saturated.clear();
    for (Columns3* triad : {&all.gyro, &all.accel, &all.gyro_temperature, &all.accel_temperature})
      for (auto& column : *triad) column.clear();
  }
  add(all.time_ns, piece.time_ns);
  for (const auto triad : {&Recording::gyro, &Recording::accel, &Recording::gyro_temperature, &Recording::accel_temperature})
    for (std::size_t axis = 0; axis < 3; ++axis) add((all.*triad)[axis], (piece.*triad)[axis]);
  for (const std::size_t i : piece.saturated)
    if (i >= samples.begin && i < samples.end) all.saturated.push_back(before + i - samples.begin);
}

Recording completed(Recording all, const RecordingOptions& options) {
  all.interval_s = nominal_interval(all.time_ns, options);
  add_clipped(all, options);
  all.gaps = find_gaps(all.time_ns, all.interval_s);
  return all;
}

Recording make_recording(Nanoseconds t, Columns3 gyro, Columns3 accel, RecordingOptions options) {
  std::vector<std::int64_t> time_ns = std::move(t.count);
  check_options(options);
  expect_increasing(options.name, time_ns);
  options.interval_s = nominal_interval(time_ns, options);
  Recording recording = convert_readings(std::move(gyro), std::move(accel), options);
  recording.time_ns = std::move(time_ns);
  validate(recording);
  add_clipped(recording, options);
  recording.gaps = find_gaps(recording.time_ns, recording.interval_s);
  return recording;
}

std::vector<std::int64_t> nanoseconds_of(const std::vector<double>& t, const std::string& name) {
  constexpr double longest_s = 9e9;  // of 64 bits of nanoseconds
  std::vector<std::int64_t> time_ns;
  time_ns.reserve(t.size());
  for (std::size_t i = 0; i < t.size(); ++i) {
    if (!(std::abs(t[i]) < longest_s)) throw Error(fmt::format("{}: time: sample {} is {}; expected seconds", name, i, t[i]));
    time_ns.push_back(std::llround(1e9 * t[i]));
  }
  return time_ns;
}

Recording make_recording(const std::vector<double>& t, Columns3 gyro, Columns3 accel, RecordingOptions options) {
  Nanoseconds stamps{nanoseconds_of(t, options.name)};
  return make_recording(std::move(stamps), std::move(gyro), std::move(accel), std::move(options));
}

}  // namespace imulab
