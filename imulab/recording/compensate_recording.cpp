#include "imulab/compensate.hpp"
#include "imulab/error.hpp"
#include "imulab/model/compensation_derivatives.hpp"
#include "imulab/outlier_filter.hpp"
#include "imulab/recording/compensated_readings.hpp"
#include "imulab/recording/validate.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <utility>

namespace imulab {

namespace {

template <class Out>
std::array<Out, 3> spans(auto& columns) {
  return {Out(columns[0]), Out(columns[1]), Out(columns[2])};
}

bool out_of_range(const TriadModel& m, const Columns3& temperature, std::size_t sample) {
  if (!m.temperature || temperature[0].empty()) return false;
  return std::any_of(temperature.begin(), temperature.end(), [&](const auto& t) { return !in_range(*m.temperature, t[sample]); });
}

/// Samples with a replaced reading.
std::vector<std::size_t> replace_outliers(Recording& r) {
  const std::vector<std::uint8_t> marks = reject_outliers({r.gyro[0], r.gyro[1], r.gyro[2], r.accel[0], r.accel[1], r.accel[2]});
  std::vector<std::size_t> replaced;
  for (std::size_t i = 0; i < marks.size(); ++i)
    if (marks[i] != 0) replaced.push_back(i);
  return replaced;
}

/// A calibration made from counts is meaningless for physical readings, and the reverse.
void check_unit(const Recording& recording, const char* triad, const std::string& unit, const TriadModel& model) {
  if (!model.raw_unit.empty() && model.raw_unit != unit)
    throw Error((recording.name.empty() ? "recording" : recording.name) + ": " + triad + " is in " + (unit.empty() ? "no unit" : unit) +
                ", expected " + model.raw_unit + ", which the calibration was made from");
}

/// Readings beyond what a double holds after the third power are no sensor's.
void expect_finite(const Recording& r) {
  for (const auto* triad : {&r.gyro, &r.accel})
    for (const auto& column : *triad)
      for (std::size_t i = 0; i < column.size(); ++i)
        if (!std::isfinite(column[i]))
          throw Error(r.name + ": the sample at " + std::to_string(r.time_s(i)) + " s has a reading that no compensation makes finite");
}

}  // namespace

CompensatedRecording compensate(const SensorModel& model, Recording recording, Outliers outliers) {
  CompensatedRecording out{std::move(recording), {}, {}};
  Recording& r = out.recording;
  expect_both_triads(r);
  check_unit(r, "accel", r.accel_unit, model.accel);
  check_unit(r, "gyro", r.gyro_unit, model.gyro);
  if (outliers == Outliers::reject) out.replaced = replace_outliers(r);
  using In = std::span<const double>;
  const RawColumns raw{spans<In>(r.gyro), spans<In>(r.accel), spans<In>(r.gyro_temperature), spans<In>(r.accel_temperature)};
  try {
    compensate(model, raw, {spans<std::span<double>>(r.gyro), spans<std::span<double>>(r.accel)});
  } catch (const Error& e) {
    throw Error(r.name + ": " + e.what());
  }
  expect_finite(r);
  r.gyro_unit = "rad/s";
  r.accel_unit = "m/s^2";
  for (std::size_t i = 0; i < r.size(); ++i)
    if (out_of_range(model.accel, r.accel_temperature, i) || out_of_range(model.gyro, r.gyro_temperature, i)) out.out_of_range.push_back(i);
  return out;
}

void remove_lever_arms(Recording& r, const Matrix3d& lever_arm) {
  expect_both_triads(r);
  if (!lever_arm.allFinite()) throw Error("a lever arm is not finite; expected meters");
  const auto rate = [&](std::size_t i) { return Vector3d(r.gyro[0][i], r.gyro[1][i], r.gyro[2][i]); };
  for (std::size_t i = 0; i < r.size(); ++i) {
    const std::size_t before = i > 0 && !r.follows_gap(i) ? i - 1 : i, after = i + 1 < r.size() && !r.follows_gap(i + 1) ? i + 1 : i;
    Vector3d acceleration = Vector3d::Zero();
    if (after > before) acceleration = (rate(after) - rate(before)) / (r.time_s(after) - r.time_s(before));
    const Vector3d effect = size_effect(rate(i), acceleration, lever_arm);
    for (std::size_t axis = 0; axis < 3; ++axis) r.accel[axis][i] -= effect[static_cast<Eigen::Index>(axis)];
  }
}

namespace {

constexpr std::array<Columns3 Recording::*, 4> triads{&Recording::gyro, &Recording::accel, &Recording::gyro_temperature,
                                                      &Recording::accel_temperature};

/// `first`, and `more` after it.
Recording joined(Recording first, Recording more) {
  const std::size_t n = first.size();
  if (n == 0) return more;
  first.time_ns.insert(first.time_ns.end(), more.time_ns.begin(), more.time_ns.end());
  for (const auto triad : triads)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto& column = (more.*triad)[axis];
      (first.*triad)[axis].insert((first.*triad)[axis].end(), column.begin(), column.end());
    }
  for (const std::size_t i : more.saturated) first.saturated.push_back(n + i);
  return first;
}

/// Takes the samples from `begin` on out of `r`.
Recording split(Recording& r, std::size_t begin) {
  const auto after = [begin](auto& column) {
    const auto at = column.begin() + static_cast<std::ptrdiff_t>(std::min(begin, column.size()));  // an absent column is empty
    std::remove_reference_t<decltype(column)> tail(at, column.end());
    column.erase(at, column.end());
    return tail;
  };
  Recording tail;
  tail.name = r.name, tail.interval_s = r.interval_s;
  tail.gyro_unit = r.gyro_unit, tail.accel_unit = r.accel_unit;
  tail.gyro_increment = r.gyro_increment, tail.accel_increment = r.accel_increment;
  tail.time_ns = after(r.time_ns);
  for (const auto triad : triads)
    for (std::size_t axis = 0; axis < 3; ++axis) (tail.*triad)[axis] = after((r.*triad)[axis]);
  const auto first = std::lower_bound(r.saturated.begin(), r.saturated.end(), begin);
  for (auto i = first; i != r.saturated.end(); ++i) tail.saturated.push_back(*i - begin);
  r.saturated.erase(first, r.saturated.end());
  return tail;
}

OutlierFilter::Readings readings(const Recording& r, std::size_t i) {
  return {r.gyro[0][i], r.gyro[1][i], r.gyro[2][i], r.accel[0][i], r.accel[1][i], r.accel[2][i]};
}

/// The output of the filter, in place of the samples from the first on.
struct FilteredReadings {
  Recording& recording;
  std::vector<std::size_t> replaced{};
  std::size_t size = 0;

  void put(const OutlierFilter::Output& out) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      recording.gyro[axis][size] = out.readings[axis];
      recording.accel[axis][size] = out.readings[3 + axis];
    }
    if (out.replaced != 0) replaced.push_back(size);
    ++size;
  }
};

}  // namespace

Compensator::Compensator(SensorModel model, Outliers outliers) : model_(std::move(model)) {
  if (outliers == Outliers::reject) filter_.emplace();
}

CompensatedRecording Compensator::next(Recording piece) {
  expect_both_triads(piece);
  if (!filter_) return compensate(model_, std::move(piece));
  const std::size_t taken = held_.size();
  Recording samples = joined(std::move(held_), std::move(piece));
  FilteredReadings filtered{samples};
  for (std::size_t i = taken; i < samples.size(); ++i)
    if (const auto out = filter_->push(readings(samples, i))) filtered.put(*out);
  held_ = split(samples, filtered.size);
  CompensatedRecording out = compensate(model_, std::move(samples));
  out.replaced = std::move(filtered.replaced);
  return out;
}

CompensatedRecording Compensator::rest() {
  if (held_.size() == 0) return {};
  CompensatedRecording out = compensate(model_, std::move(held_));
  held_ = {};
  return out;
}

void CompensatedReadings::take_part_with(std::size_t i) {
  constexpr std::size_t back = 8, most = 1024;
  if (i >= recording_.size()) throw Error(fmt::format("{}: sample {}; expected one of {}", recording_.name, i, recording_.size()));
  begin_ = std::max(i, back) - back;
  const auto begin = static_cast<std::ptrdiff_t>(begin_), end = static_cast<std::ptrdiff_t>(std::min(begin_ + most, recording_.size()));
  Recording part;
  part.name = recording_.name, part.interval_s = recording_.interval_s;
  part.gyro_unit = recording_.gyro_unit, part.accel_unit = recording_.accel_unit;
  part.time_ns.assign(recording_.time_ns.begin() + begin, recording_.time_ns.begin() + end);
  for (const auto triad : {&Recording::gyro, &Recording::accel, &Recording::gyro_temperature, &Recording::accel_temperature})
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (const auto& column = (recording_.*triad)[axis]; !column.empty()) (part.*triad)[axis].assign(column.begin() + begin, column.begin() + end);
  part_ = compensate(model_, std::move(part)).recording;
}

}  // namespace imulab
