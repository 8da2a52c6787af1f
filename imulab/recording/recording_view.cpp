#include "imulab/recording/recording_view.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

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

std::vector<Range> without_interruptions(const RecordingView& recording, Range range, double shortest_gap_s) {
  std::vector<Range> pieces;
  auto gap = std::lower_bound(recording.gaps.begin(), recording.gaps.end(), range.begin + 1);
  auto saturated = std::lower_bound(recording.saturated.begin(), recording.saturated.end(), range.begin);
  const auto is_short = [&](std::size_t i) { return shortest_gap_s > 0 && recording.time_s(i) - recording.time_s(i - 1) < shortest_gap_s; };
  while (range.begin < range.end) {
    while (gap != recording.gaps.end() && *gap < range.end && is_short(*gap)) ++gap;
    const std::size_t next_gap = gap != recording.gaps.end() ? *gap : range.end;
    const std::size_t next_saturated = saturated != recording.saturated.end() ? *saturated : range.end;
    const std::size_t cut = std::min({next_gap, next_saturated, range.end});
    if (cut > range.begin) pieces.push_back({range.begin, cut});
    range.begin = cut;
    if (next_saturated == cut && cut < range.end) {  // the sample itself is lost
      ++range.begin;
      ++saturated;
    }
    if (next_gap == cut && gap != recording.gaps.end()) ++gap;
    if (cut == range.end) break;
  }
  return pieces;
}

double start_of_sample(const Recording& recording, std::size_t i) { return recording.time_s(i) - recording.interval(i, recording.gyro_increment); }

Range longest_piece(const RecordingView& r, const Range& range) {
  Range longest;
  if (range.size() == 0) return longest;
  for (const Range& piece : without_interruptions(r, range))
    if (piece.size() > longest.size()) longest = piece;
  return longest;
}

Range samples_covering(const Recording& r, double begin, double end) {
  const double rounding = 1e-3 * r.interval_s;
  const auto ns = [](double s) { return static_cast<std::int64_t>(std::llround(1e9 * s)); };
  const auto first = std::upper_bound(r.time_ns.begin(), r.time_ns.end(), ns(begin + rounding));
  const auto last = std::lower_bound(r.time_ns.begin(), r.time_ns.end(), ns(end - rounding));
  const Range range{static_cast<std::size_t>(first - r.time_ns.begin()), static_cast<std::size_t>(last - r.time_ns.begin()) + 1};
  if (range.begin >= r.size() || range.end > r.size() || start_of_sample(r, range.begin) > begin + rounding) return {};
  const auto pieces = without_interruptions(r, range);
  return pieces.size() == 1 && pieces.front() == range ? range : Range{};
}

}  // namespace imulab
