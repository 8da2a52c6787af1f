#include "imulab/recording/resample.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace imulab {
namespace {

/// Begin of each interval [ns]: the stamp before, or one nominal interval before where that is too far.
std::vector<std::int64_t> interval_begins(const std::vector<std::int64_t>& time_ns, double interval_s) {
  const auto nominal = static_cast<std::int64_t>(std::llround(1e9 * interval_s));
  std::vector<std::int64_t> begins(time_ns.size());
  for (std::size_t i = 0; i < time_ns.size(); ++i) {
    const bool follows = i > 0 && static_cast<double>(time_ns[i] - time_ns[i - 1]) <= 1.5e9 * interval_s;
    begins[i] = follows ? time_ns[i - 1] : time_ns[i] - nominal;
  }
  return begins;
}

}  // namespace

Resampled resample_means(const std::vector<std::int64_t>& time_ns, double source_interval_s, const std::vector<std::vector<double>>& columns,
                         bool increment, const std::vector<std::int64_t>& at, double interval_s) {
  const std::vector<std::int64_t> source_begin = interval_begins(time_ns, source_interval_s), target_begin = interval_begins(at, interval_s);
  Resampled result;
  result.covered.assign(at.size(), 0);
  result.columns.assign(columns.size(), std::vector<double>(at.size(), 0.0));
  constexpr double enough = 0.99;  // of an interval: stamps jitter
  std::size_t first = 0;
  for (std::size_t i = 0; i < at.size(); ++i) {
    while (first < time_ns.size() && time_ns[first] <= target_begin[i]) ++first;
    const double length = static_cast<double>(at[i] - target_begin[i]);
    double overlap_sum = 0;
    for (std::size_t k = first; k < time_ns.size() && source_begin[k] < at[i]; ++k) {
      const double overlap = static_cast<double>(std::min(at[i], time_ns[k]) - std::max(target_begin[i], source_begin[k]));
      if (overlap <= 0) continue;
      overlap_sum += overlap;
      const double weight = overlap / (increment ? static_cast<double>(time_ns[k] - source_begin[k]) : length);
      for (std::size_t c = 0; c < columns.size(); ++c) result.columns[c][i] += weight * columns[c][k];
    }
    result.covered[i] = overlap_sum >= enough * length;
    for (auto& column : result.columns) column[i] *= overlap_sum > 0 ? length / overlap_sum : 0;  // what little is missing is as the rest
  }
  return result;
}

std::vector<std::vector<double>> interpolate(const std::vector<std::int64_t>& time_ns, const std::vector<std::vector<double>>& columns,
                                             const std::vector<std::int64_t>& at) {
  std::vector<std::vector<double>> result(columns.size(), std::vector<double>(at.size()));
  std::size_t after = 0;
  for (std::size_t i = 0; i < at.size(); ++i) {
    while (after < time_ns.size() && time_ns[after] < at[i]) ++after;
    const std::size_t right = std::min(after, time_ns.size() - 1), left = after == 0 ? 0 : after - 1;
    const double part = right == left ? 0 : static_cast<double>(at[i] - time_ns[left]) / static_cast<double>(time_ns[right] - time_ns[left]);
    for (std::size_t c = 0; c < columns.size(); ++c) result[c][i] = columns[c][left] + part * (columns[c][right] - columns[c][left]);
  }
  return result;
}

}  // namespace imulab
