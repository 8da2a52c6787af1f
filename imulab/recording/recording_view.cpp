#include "imulab/recording/recording_view.hpp"

#include <cmath>

namespace imulab {

namespace {

constexpr double boundary_tolerance = 0.01;  // of an interval

std::size_t count_in(std::span<const std::size_t> ascending, const Range& range) {
  const auto first = std::lower_bound(ascending.begin(), ascending.end(), range.begin);
  return static_cast<std::size_t>(std::lower_bound(first, ascending.end(), range.end) - first);
}

}  // namespace

std::string axis_name(std::size_t column) { return std::string(column < accel_columns ? "gyro" : "accel") + '.' + "xyz"[column % 3]; }

RecordingView::RecordingView(const Recording& r)
    : name(r.name),
      interval_s(r.interval_s),
      time_ns(r.time_ns),
      gyro_unit(r.gyro_unit),
      accel_unit(r.accel_unit),
      saturated(r.saturated),
      gaps(r.gaps) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    columns[gyro_columns + axis] = r.gyro[axis];
    columns[accel_columns + axis] = r.accel[axis];
    columns[gyro_temperature_columns + axis] = r.gyro_temperature[axis];
    columns[accel_temperature_columns + axis] = r.accel_temperature[axis];
  }
}

Range RecordingView::samples_in(double begin_s, double end_s) const {
  const auto ns = [](double s) { return static_cast<std::int64_t>(std::llround(1e9 * s)); };
  const double tolerance = boundary_tolerance * interval_s;
  const auto first = std::lower_bound(time_ns.begin(), time_ns.end(), ns(begin_s + interval_s - tolerance));
  const auto last = std::upper_bound(first, time_ns.end(), ns(end_s + tolerance));
  return {static_cast<std::size_t>(first - time_ns.begin()), static_cast<std::size_t>(last - time_ns.begin())};
}

std::size_t RecordingView::saturated_in(const Range& range) const { return count_in(saturated, range); }

std::size_t RecordingView::gaps_in(const Range& range) const { return count_in(gaps, range); }

std::span<const double> RecordingView::samples(std::size_t column, const Range& range, std::vector<double>& buffer) const {
  if (on_disk == nullptr) return columns[column].subspan(range.begin, range.size());
  on_disk->read(column, range, buffer);
  return buffer;
}

}  // namespace imulab
