#include "imulab/recording/clipping.hpp"

#include <algorithm>
#include <cmath>

namespace imulab {

namespace {

struct Level {
  double value;
  std::size_t count;
};

/// Distinct values from the extreme inward, with their counts, as far as `levels`. `sign` +1: from the largest down.
std::vector<Level> outer_levels(const std::vector<double>& channel, int sign, std::size_t levels) {
  std::vector<Level> found;
  for (double bound = HUGE_VAL; found.size() < levels;) {
    Level next{-HUGE_VAL, 0};
    for (const double reading : channel) {
      const double value = sign * reading;
      if (!(value < bound) || value < next.value) continue;
      next.count = value == next.value ? next.count + 1 : 1;
      next.value = value;
    }
    if (next.count == 0) break;
    found.push_back(next);
    bound = next.value;
  }
  return found;
}

/// Longest run of samples at this value, and of samples between both extremes.
struct Runs {
  std::size_t at = 0, elsewhere = 0;
};

Runs longest_runs(const std::vector<double>& channel, double value) {
  const auto [least, most] = std::minmax_element(channel.begin(), channel.end());
  Runs runs;
  for (std::size_t begin = 0; begin < channel.size();) {
    std::size_t end = begin + 1;
    while (end < channel.size() && channel[end] == channel[begin]) ++end;
    if (channel[begin] == value) runs.at = std::max(runs.at, end - begin);
    if (channel[begin] > *least && channel[begin] < *most) runs.elsewhere = std::max(runs.elsewhere, end - begin);
    begin = end;
  }
  return runs;
}

bool clips(const std::vector<double>& channel, int sign) {
  const std::vector<Level> levels = outer_levels(channel, sign, 4);
  if (levels.size() < 4 || levels[0].count < 3) return false;  // a constant channel is stuck, not clipped
  const std::size_t beside = std::max({levels[1].count, levels[2].count, levels[3].count});
  if (levels[0].count < 3 * beside) return false;
  const Runs runs = longest_runs(channel, sign * levels[0].value);
  return runs.elsewhere == 1 || runs.at >= 3 * runs.elsewhere;
}

}  // namespace

std::vector<std::size_t> clipped_samples(const std::vector<double>& channel) {
  std::vector<std::size_t> samples;
  for (const int sign : {1, -1}) {
    if (!clips(channel, sign)) continue;
    const double limit = sign > 0 ? *std::max_element(channel.begin(), channel.end()) : *std::min_element(channel.begin(), channel.end());
    for (std::size_t i = 0; i < channel.size(); ++i)
      if (channel[i] == limit) samples.push_back(i);
  }
  std::sort(samples.begin(), samples.end());
  return samples;
}

}  // namespace imulab
