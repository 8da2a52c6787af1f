#include "imulab/recording/compensator.hpp"

#include <algorithm>
#include <type_traits>
#include <utility>

namespace imulab {

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

}  // namespace imulab
