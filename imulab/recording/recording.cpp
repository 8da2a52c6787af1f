#include "imulab/recording/recording.hpp"

#include <algorithm>
#include <cmath>

namespace imulab {

namespace {

constexpr double boundary_tolerance = 0.01;  // of an interval

std::size_t count_in(const std::vector<std::size_t>& ascending, const Range& range) {
  const auto first = std::lower_bound(ascending.begin(), ascending.end(), range.begin);
  return static_cast<std::size_t>(std::lower_bound(first, ascending.end(), range.end) - first);
}

}  // namespace

double Recording::interval(std::size_t i, bool increment) const {
  if (increment || i == 0 || follows_gap(i)) return interval_s;
  return 1e-9 * static_cast<double>(time_ns[i] - time_ns[i - 1]);
}

bool Recording::follows_gap(std::size_t i) const { return std::binary_search(gaps.begin(), gaps.end(), i); }

Range Recording::samples_in(double begin_s, double end_s) const {
  const auto ns = [](double s) { return static_cast<std::int64_t>(std::llround(1e9 * s)); };
  const double tolerance = boundary_tolerance * interval_s;
  const auto first = std::lower_bound(time_ns.begin(), time_ns.end(), ns(begin_s + interval_s - tolerance));
  const auto last = std::upper_bound(first, time_ns.end(), ns(end_s + tolerance));
  return {static_cast<std::size_t>(first - time_ns.begin()), static_cast<std::size_t>(last - time_ns.begin())};
}

std::size_t Recording::saturated_in(const Range& range) const { return count_in(saturated, range); }

std::size_t Recording::gaps_in(const Range& range) const { return count_in(gaps, range); }

}  // namespace imulab
