#include "imulab/recording/spikes.hpp"

#include "imulab/core/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace imulab {

namespace {

constexpr double spike_size = 30, agreement = 10;  // in sizes of a usual difference
constexpr double most_removed = 0.005;             // of the samples: more are the sensor's own noise
constexpr std::size_t longest_spike = 2;           // samples: as many as are filled in

/// Returns the median of the absolute differences between successive readings that differ; 0 if none does.
double usual_difference(const std::vector<double>& channel) {
  constexpr std::size_t most = 65536;
  const std::size_t stride = channel.size() / most + 1;
  std::vector<double> sizes;
  for (std::size_t i = 1; i < channel.size(); i += stride)
    if (const double size = std::abs(channel[i] - channel[i - 1]); size > 0) sizes.push_back(size);
  return sizes.empty() ? 0 : quantile(sizes, 0.5);
}

/// Marks the spikes of a channel.
void mark_spikes(const std::vector<double>& x, std::vector<char>& spike) {
  const double usual = usual_difference(x);
  if (!(usual > 0)) return;
  const auto agree = [&](double a, double b) { return std::abs(a - b) <= agreement * usual; };
  for (std::size_t i = 2; i + 2 < x.size(); ++i)
    for (std::size_t length = 1; length <= longest_spike && i + length + 1 < x.size(); ++length) {
      const double before = x[i - 1], after = x[i + length], mean = 0.5 * (before + after);
      const auto is_far = [&](double reading) { return std::abs(reading - mean) > spike_size * usual; };
      if (!agree(before, after) || !agree(x[i - 2], before) || !agree(after, x[i + length + 1])) continue;  // a knock rings
      if (!std::all_of(&x[i], &x[i] + length, is_far)) continue;
      std::fill_n(&spike[i], length, 1);
      break;
    }
}

void keep_others(std::vector<double>& column, const std::vector<char>& removed) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < column.size(); ++i)
    if (!removed[i]) column[kept++] = column[i];
  column.resize(kept);
}

}  // namespace

std::size_t remove_spikes(Recording& r) {
  std::vector<char> spike(r.size(), 0);
  for (const Columns3* triad : {&r.gyro, &r.accel})
    for (const std::vector<double>& column : *triad)
      if (column.size() == r.size()) mark_spikes(column, spike);
  const auto count = static_cast<std::size_t>(std::ranges::count(spike, 1));
  if (count == 0 || static_cast<double>(count) > most_removed * static_cast<double>(r.size())) return 0;
  for (Columns3* const triad : {&r.gyro, &r.accel, &r.gyro_temperature, &r.accel_temperature})
    for (std::vector<double>& column : *triad)
      if (column.size() == r.size()) keep_others(column, spike);
  std::vector<std::int64_t> time_ns;
  std::vector<std::size_t> gaps, saturated, starts;
  bool missing = false;
  for (std::size_t i = 0; i < r.size(); ++i) {
    const auto has = [&](const std::vector<std::size_t>& samples) { return std::ranges::binary_search(samples, i); };
    missing = missing || spike[i] != 0;
    if (spike[i]) continue;
    if (missing || has(r.gaps)) gaps.push_back(time_ns.size());
    if (has(r.saturated)) saturated.push_back(time_ns.size());
    if (has(r.starts)) starts.push_back(time_ns.size());
    missing = false;
    time_ns.push_back(r.time_ns[i]);
  }
  r.time_ns = std::move(time_ns), r.gaps = std::move(gaps), r.saturated = std::move(saturated), r.starts = std::move(starts);
  return count;
}

}  // namespace imulab
