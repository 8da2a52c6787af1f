#include "imulab/recording/validate.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/stamp_text.hpp"
#include "imulab/recording/stamps.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <utility>

namespace imulab {
namespace {

void check_length(const Recording& r, std::string_view name, const Columns3& columns) {
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (columns[axis].size() != r.size())
      throw Error(fmt::format("{}: {} {}: {} samples; expected {}, one for each stamp", r.name, name, "xyz"[axis], columns[axis].size(), r.size()));
}

/// Finite readings no larger than `largest`.
void check_readings(const Recording& r, std::string_view name, const Columns3& columns, double largest) {
  const auto wrong = [&](double value) { return !(std::abs(value) <= largest); };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (std::count_if(columns[axis].begin(), columns[axis].end(), wrong) == 0) continue;  // without a branch a sample
    const auto bad = std::find_if(columns[axis].begin(), columns[axis].end(), wrong);
    const auto i = static_cast<std::size_t>(bad - columns[axis].begin());
    throw Error(fmt::format("{}: {} {}: sample {} at {} s is {}; expected a {}", r.name, name, "xyz"[axis], i, stamp_text(r.time_ns[i]), *bad,
                            std::isfinite(*bad) ? "reading that a sensor can give" : "finite number"));
  }
}

void check_unit(const Recording& r, std::string_view name, std::string_view unit, std::string_view expected) {
  if (unit != "count" && unit != expected)
    throw Error(fmt::format("{}: {}: the unit is \"{}\"; expected \"count\" or \"{}\"", r.name, name, unit, expected));
}

void check_indices(const Recording& r, std::string_view name, const std::vector<std::size_t>& indices, std::size_t least) {
  for (std::size_t k = 0; k < indices.size(); ++k)
    if (indices[k] < (k == 0 ? least : indices[k - 1] + 1) || indices[k] >= r.size())
      throw Error(
          fmt::format("{}: {}: entry {} is sample {}; expected ascending samples from {} to {}", r.name, name, k, indices[k], least, r.size() - 1));
}

void check_interval(const Recording& r) {
  if (mostly_spaced(r.time_ns, r.interval_s)) return;  // cheaper than the median, and the usual case
  const StampIntervals stamps = stamp_intervals(r.time_ns, r.gaps);
  if (stamps.median > 0 && !stamps.allow(r.interval_s))
    throw Error(fmt::format("{}: the interval is {:.6g} s, but the stamps' differences are {:.6g} s (median); expected agreement within 2 %", r.name,
                            r.interval_s, stamps.median));
}

}  // namespace

double largest_reading(std::string_view unit) { return unit == "m/s^2" ? 1e5 : unit == "rad/s" ? 1e4 : 3e14; }

void validate(const Recording& r) {
  if (r.size() == 0) throw Error(fmt::format("{}: no samples; expected at least one", r.name));
  check_length(r, "gyro", r.gyro);
  check_length(r, "accel", r.accel);
  expect_increasing(r.name, r.time_ns);
  if (!(r.interval_s > 0 && std::isfinite(r.interval_s)))
    throw Error(fmt::format("{}: the interval is {} s; expected a positive number", r.name, r.interval_s));
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
  check_interval(r);
}

}  // namespace imulab
