#include "imulab/recording/pieces.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace imulab {

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
