#include "imulab/recording/validate.hpp"

#include "imulab/core/stamp_text.hpp"
#include "imulab/error.hpp"
#include "imulab/recording.hpp"
#include "imulab/recording/clock.hpp"
#include "imulab/session.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <tuple>
#include <utility>

namespace imulab {

namespace {

/// As messages name it; without a name it is in memory, or was moved from.
std::string name_of(const Recording& r) { return r.name.empty() ? "recording" : r.name; }

void check_length(const Recording& r, std::string_view name, const Columns3& columns) {
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (columns[axis].size() != r.size())
      throw Error(
          fmt::format("{}: {} {}: {} samples; expected {}, one for each stamp", name_of(r), name, "xyz"[axis], columns[axis].size(), r.size()));
}

/// A recording may lack one of its triads.
bool has_triad(const Columns3& columns) {
  return std::any_of(columns.begin(), columns.end(), [](const std::vector<double>& column) { return !column.empty(); });
}

/// Finite readings no larger than `largest`.
void check_readings(const Recording& r, std::string_view name, const Columns3& columns, double largest) {
  const auto wrong = [&](double value) { return !(std::abs(value) <= largest); };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (std::count_if(columns[axis].begin(), columns[axis].end(), wrong) == 0) continue;  // without a branch a sample
    const auto bad = std::find_if(columns[axis].begin(), columns[axis].end(), wrong);
    const auto i = static_cast<std::size_t>(bad - columns[axis].begin());
    throw Error(fmt::format("{}: {} {}: sample {} at {} s is {}; expected a {}", name_of(r), name, "xyz"[axis], i, stamp_text(r.time_ns[i]), *bad,
                            std::isfinite(*bad) ? "reading that a sensor can give" : "finite number"));
  }
}

void check_unit(const Recording& r, std::string_view name, std::string_view unit, std::string_view expected) {
  if (unit != "count" && unit != expected)
    throw Error(fmt::format("{}: {}: the unit is \"{}\"; expected \"count\" or \"{}\"", name_of(r), name, unit, expected));
}

void check_indices(const Recording& r, std::string_view name, const std::vector<std::size_t>& indices, std::size_t least) {
  for (std::size_t k = 0; k < indices.size(); ++k)
    if (indices[k] < (k == 0 ? least : indices[k - 1] + 1) || indices[k] >= r.size())
      throw Error(fmt::format("{}: {}: entry {} is sample {}; expected ascending samples from {} to {}", name_of(r), name, k, indices[k], least,
                              r.size() - 1));
}

void check_interval(const Recording& r) {
  if (mostly_spaced(r.time_ns, r.interval_s)) return;  // cheaper than the median, and the usual case
  const StampIntervals stamps = stamp_intervals(r.time_ns, r.gaps);
  if (stamps.median > 0 && !stamps.allow(r.interval_s))
    throw Error(fmt::format("{}: the interval is {:.6g} s, but the stamps' differences are {:.6g} s (median); expected agreement within 2 %",
                            name_of(r), r.interval_s, stamps.median));
}

}  // namespace

double largest_reading(std::string_view unit) { return unit == "m/s^2" ? 1e5 : unit == "rad/s" ? 1e4 : 3e14; }

void validate(const Recording& r) {
  if (r.size() == 0) throw Error(fmt::format("{}: no samples; expected at least one", name_of(r)));
  if (!has_triad(r.gyro) && !has_triad(r.accel)) throw Error(fmt::format("{}: neither gyros nor accelerometers; expected one of them", name_of(r)));
  if (has_triad(r.gyro)) check_length(r, "gyro", r.gyro);
  if (has_triad(r.accel)) check_length(r, "accel", r.accel);
  expect_increasing(name_of(r), r.time_ns);
  if (!(r.interval_s > 0 && std::isfinite(r.interval_s)))
    throw Error(fmt::format("{}: the interval is {} s; expected a positive number", name_of(r), r.interval_s));
  check_readings(r, "gyro", r.gyro, largest_reading(r.gyro_unit));
  check_readings(r, "accel", r.accel, largest_reading(r.accel_unit));
  for (const auto& [name, columns] : {std::pair{"gyro temperature", &r.gyro_temperature}, std::pair{"accel temperature", &r.accel_temperature}}) {
    if (std::all_of(columns->begin(), columns->end(), [](const auto& column) { return column.empty(); })) continue;  // no thermal readings
    check_length(r, name, *columns);
    check_readings(r, name, *columns, std::numeric_limits<double>::max());
  }
  check_unit(r, "gyro", r.gyro_unit, "rad/s");
  check_unit(r, "accel", r.accel_unit, "m/s^2");
  check_indices(r, "gaps", r.gaps, 1);
  check_indices(r, "saturated", r.saturated, 0);
  check_indices(r, "starts", r.starts, 1);
  check_interval(r);
}

bool is_body_axis(const BodyAxis& axis) { return axis.index >= 0 && axis.index < 3 && (axis.sign == 1 || axis.sign == -1); }

bool are_body_axes(const std::array<BodyAxis, 3>& axes) {
  return std::all_of(axes.begin(), axes.end(), is_body_axis) && axes[0].index != axes[1].index && axes[1].index != axes[2].index &&
         axes[2].index != axes[0].index;
}

void expect_inside(const Range& range, std::size_t samples, std::string_view what) {
  if (range.begin > range.end || range.end > samples)
    throw Error(fmt::format("{}: samples {} to {}; expected an ascending range within {} samples", what, range.begin, range.end, samples));
}

void expect_both_triads(const Recording& r) {
  if (r.size() > 0)
    for (const auto& [name, columns] : {std::pair{"gyros", &r.gyro}, std::pair{"accelerometers", &r.accel}})
      if (!has_triad(*columns))
        throw Error(fmt::format("{}: has no {}; both triads are compensated together: expected a recording of both", name_of(r), name));
  check_length(r, "gyro", r.gyro);
  check_length(r, "accel", r.accel);
  if (has_triad(r.gyro_temperature)) check_length(r, "gyro temperature", r.gyro_temperature);
  if (has_triad(r.accel_temperature)) check_length(r, "accel temperature", r.accel_temperature);
}

namespace {

RecordingSource declaration_of(const Recording& recording) {
  RecordingSource source;
  source.file = recording.name;
  source.gyro.unit = recording.gyro_unit;
  source.accel.unit = recording.accel_unit;
  if (!recording.gyro_temperature[0].empty()) source.gyro_temperature = ThermalSource{};  // degC
  if (!recording.accel_temperature[0].empty()) source.accel_temperature = ThermalSource{};
  return source;
}

void check_declared(const Recording& recording, const RecordingSource& source, std::size_t number, std::vector<std::string>& problems) {
  if (recording.name != source.file)
    problems.push_back(fmt::format("recording {} is named {}; expected {} as in the session", number, recording.name, source.file));
  for (const auto& [triad, columns, unit, declared] : {std::tuple{"gyro", &recording.gyro, &recording.gyro_unit, &source.gyro.unit},
                                                       std::tuple{"accel", &recording.accel, &recording.accel_unit, &source.accel.unit}}) {
    if ((recording.size() == 0 || has_triad(*columns)) && (*declared == "count") != (*unit == "count"))
      problems.push_back(fmt::format("{}: {} is in {}; the session declares {}", name_of(recording), triad, *unit, *declared));
  }
}

}  // namespace

Session declared_session(Session session, std::span<const Recording> recordings) {
  if (session.recordings.empty()) {
    for (const Recording& recording : recordings) session.recordings.push_back(declaration_of(recording));
    if (recordings.size() == 1)
      for (Step& step : session.steps) step.recording = recordings.front().name;
  }
  if (recordings.size() != session.recordings.size())
    throw Error(fmt::format("{} recordings were given; the session declares {}", recordings.size(), session.recordings.size()));
  std::vector<std::string> problems;
  for (std::size_t k = 0; k < recordings.size(); ++k) check_declared(recordings[k], session.recordings[k], k + 1, problems);
  throw_problems("", problems);
  return session;
}

}  // namespace imulab
