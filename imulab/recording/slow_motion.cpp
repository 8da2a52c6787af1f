#include "imulab/recording/slow_motion.hpp"

#include "imulab/core/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace imulab {

namespace {

constexpr double block_s = 1, times_usual = 20;  // of the change from block to block
constexpr std::size_t fewest_blocks = 10;
constexpr double infinity = std::numeric_limits<double>::infinity();

/// Means over blocks of so many samples, without a last shorter one; and the smallest change of the readings there is.
struct Means {
  std::vector<double> of_block;
  double step = infinity;
};

Means means_of(const RecordingView& recording, std::size_t column, const Range& range, std::size_t block) {
  Means means;
  for_each_block(recording, column, range, usual_block / block * block + block, [&](std::span<const double> samples) {
    for (std::size_t i = 1; i < samples.size(); ++i) {
      const double change = std::abs(samples[i] - samples[i - 1]);
      means.step = std::min(means.step, change > 0 ? change : infinity);  // no branch: which readings are equal is chance
    }
    for (std::size_t begin = 0; begin + block <= samples.size(); begin += block)
      means.of_block.push_back(
          std::accumulate(samples.begin() + static_cast<std::ptrdiff_t>(begin), samples.begin() + static_cast<std::ptrdiff_t>(begin + block), 0.0) /
          static_cast<double>(block));
  });
  return means;
}

}  // namespace

std::vector<Range> between_slow_motion(const RecordingView& recording, const Range& range) {
  const auto block = static_cast<std::size_t>(std::max(1.0, std::round(block_s / recording.interval_s)));
  if (range.size() < fewest_blocks * block) return {range};
  std::vector<char> moving(range.size() / block, 0);
  for (std::size_t column = gyro_columns; column < gyro_temperature_columns; ++column) {
    if (!recording.has(column)) continue;
    const Means means = means_of(recording, column, range, block);
    std::vector<double> change(means.of_block.size() - 1);
    for (std::size_t k = 0; k < change.size(); ++k) change[k] = std::abs(means.of_block[k + 1] - means.of_block[k]);
    const double most = std::max(times_usual * median(change), 2 * means.step);
    for (std::size_t k = 0; k < change.size(); ++k)
      if (change[k] > most) moving[k] = moving[k + 1] = 1;
  }
  std::vector<Range> parts;
  for (std::size_t k = 0; k < moving.size(); ++k) {
    if (moving[k]) continue;
    const std::size_t begin = range.begin + k * block;
    while (k + 1 < moving.size() && !moving[k + 1]) ++k;
    parts.push_back({begin, k + 1 == moving.size() ? range.end : range.begin + (k + 1) * block});
  }
  return parts;
}

}  // namespace imulab
