#include "imulab/inspection/clock_quality.hpp"

#include "imulab/recording/even_stamps.hpp"
#include "imulab/recording/stamps.hpp"

#include <algorithm>

namespace imulab::inspection {

ClockQuality clock_quality(const std::vector<std::int64_t>& time_ns) {
  ClockQuality quality;
  for (std::size_t i = 1; i < time_ns.size(); ++i) {
    quality.repeated += time_ns[i] == time_ns[i - 1];
    if (time_ns[i] < time_ns[i - 1] && quality.backward++ == 0) quality.first_backward = i;
  }
  if (quality.backward > 0 || time_ns.size() < 3) return quality;
  std::vector<std::int64_t> stamps = ascending(time_ns);
  for (std::int64_t& stamp : stamps) stamp -= time_ns.front();
  const StampIntervals intervals = stamp_intervals(stamps);
  quality.interval_s = intervals.median;
  quality.rate_hz = intervals.mean > 0 ? 1 / intervals.mean : 0;
  const std::vector<std::size_t> gaps = find_gaps(stamps, intervals.mean);
  quality.gaps = gaps.size();
  for (const std::size_t i : gaps) quality.largest_gap_s = std::max(quality.largest_gap_s, 1e-9 * static_cast<double>(stamps[i] - stamps[i - 1]));
  if (const auto even = even_clock(stamps)) quality.scatter_s = even->scatter_s;
  return quality;
}

std::vector<std::int64_t> ascending(std::vector<std::int64_t> time_ns) {
  for (std::size_t i = 1; i < time_ns.size(); ++i) time_ns[i] = std::max(time_ns[i], time_ns[i - 1] + 1);
  return time_ns;
}

}  // namespace imulab::inspection
