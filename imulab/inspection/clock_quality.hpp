// How good the stamps of a recording are.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace imulab::inspection {

struct ClockQuality {
  double interval_s = 0;  ///< median
  double rate_hz = 0;     ///< by the mean, without gaps
  double scatter_s = 0;   ///< RMS about an even clock; 0 where there is none
  double largest_gap_s = 0;
  std::size_t gaps = 0, repeated = 0;  ///< stamps that follow after missing samples, or equal the one before
  std::size_t backward = 0, first_backward = 0;
};

/// Of all rows.
ClockQuality clock_quality(const std::vector<std::int64_t>& time_ns);

/// The stamps, each at least a nanosecond after the one before.
std::vector<std::int64_t> ascending(std::vector<std::int64_t> time_ns);

}  // namespace imulab::inspection
