#include "imulab/recording/rest_means.hpp"

#include "imulab/core/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace imulab {

namespace {

Vector3d mean_of(const Columns3& triad, Range range) {
  const Vector3d origin = reading_at(triad, range.begin);  // sums stay small next to raw counts
  Vector3d sum = Vector3d::Zero();
  for (std::size_t i = range.begin; i < range.end; ++i) sum += reading_at(triad, i) - origin;
  return origin + sum / static_cast<double>(range.size());
}

/// Standard deviation about the rests' means.
Vector3d pooled_sigma(const Columns3& triad, const std::vector<RestMeans>& rests, Vector3d RestMeans::*mean) {
  Vector3d squares = Vector3d::Zero();
  double degrees = 0;
  for (const RestMeans& rest : rests) {
    Vector3d of_rest = Vector3d::Zero();
    for (std::size_t i = rest.range.begin; i < rest.range.end; ++i) of_rest += (reading_at(triad, i) - rest.*mean).cwiseAbs2();
    squares += of_rest;
    degrees += static_cast<double>(rest.range.size()) - 1;
  }
  return (squares / std::max(degrees, 1.0)).cwiseSqrt();
}

}  // namespace

namespace {

/// Means of consecutive blocks of a column's range.
std::vector<double> block_means(const std::vector<double>& column, Range range, std::size_t block) {
  std::vector<double> means;
  for (std::size_t i = range.begin; i + block <= range.end; i += block)
    means.push_back(std::accumulate(column.begin() + static_cast<std::ptrdiff_t>(i), column.begin() + static_cast<std::ptrdiff_t>(i + block), 0.0) /
                    static_cast<double>(block));
  return means;
}

/// The blocks at either end that belong to a turn.
struct EndsOfTurns {
  std::size_t first = 0, last = 0;
};

void find_ends_of_turns(const std::vector<double>& means, EndsOfTurns& ends) {
  constexpr double most_sigmas = 5;  // standard deviations of a block's mean
  const std::size_t quarter = means.size() / 4;
  double center = 0, square = 0;
  for (std::size_t k = quarter; k < means.size() - quarter; ++k) center += means[k] / static_cast<double>(means.size() - 2 * quarter);
  for (std::size_t k = quarter; k < means.size() - quarter; ++k) square += std::pow(means[k] - center, 2);
  const double sigma = std::sqrt(square / static_cast<double>(means.size() - 2 * quarter - 1));
  for (std::size_t k = 0; k < quarter; ++k) {
    if (std::abs(means[k] - center) > most_sigmas * sigma) ends.first = std::max(ends.first, k + 1);
    if (std::abs(means[means.size() - 1 - k] - center) > most_sigmas * sigma) ends.last = std::max(ends.last, k + 1);
  }
}

}  // namespace

std::vector<Range> without_ends_of_turns(const Recording& recording, std::vector<Range> rests) {
  constexpr double block_s = 0.05;
  constexpr std::size_t margin = 2, fewest = 16;  // blocks: a turn's slow begin, and to tell the middle's scatter
  const auto block = std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(block_s / recording.interval_s)));
  for (Range& rest : rests) {
    if (rest.size() < fewest * block) continue;
    EndsOfTurns ends;
    for (const auto& column : recording.gyro) find_ends_of_turns(block_means(column, rest, block), ends);
    if (ends.first > 0) rest.begin += (ends.first + margin) * block;
    if (ends.last > 0) rest.end -= (ends.last + margin) * block;
  }
  return rests;
}

std::vector<RestMeans> summarize_rests(const Recording& recording, const std::vector<Range>& ranges) {
  std::vector<RestMeans> rests;
  for (const Range& range : ranges)
    rests.push_back({range, 0.5 * (recording.time_s(range.begin) + recording.time_s(range.end - 1)), mean_of(recording.accel, range),
                     mean_of(recording.gyro, range), recording.time_s(range.begin) - recording.interval_s, recording.time_s(range.end - 1)});
  return rests;
}

bool continues_rest(const Recording& recording, std::span<const RestMeans> rests, std::size_t k) {
  constexpr double alike = 0.02;  // of the reading: 1 deg, more than a sensor drifts in 2 K
  if (k == 0 || k >= rests.size()) return false;
  const RestMeans &before = rests[k - 1], &rest = rests[k];
  return before.range.end == rest.range.begin && recording.gaps_in({rest.range.begin, rest.range.begin + 1}) == 0 &&
         (rest.accel - before.accel).norm() < alike * before.accel.norm();
}

bool is_part_of_rest(const Recording& recording, std::span<const RestMeans> rests, std::size_t k) {
  return continues_rest(recording, rests, k) || continues_rest(recording, rests, k + 1);
}

Vector3d mean_gyro(const std::vector<RestMeans>& rests) {
  Vector3d mean = Vector3d::Zero();
  for (const RestMeans& rest : rests) mean += rest.gyro / static_cast<double>(rests.size());
  return mean;
}

Extremes accel_extremes(const std::vector<RestMeans>& rests) {
  Extremes out{rests.front().accel, rests.front().accel};
  for (const RestMeans& rest : rests) out = {out.low.cwiseMin(rest.accel), out.high.cwiseMax(rest.accel)};
  return out;
}

SampleNoise measure_noise(const Recording& recording, const std::vector<RestMeans>& rests) {
  return {pooled_sigma(recording.accel, rests, &RestMeans::accel), pooled_sigma(recording.gyro, rests, &RestMeans::gyro)};
}

double quiet_noise(const std::vector<double>& readings, const std::vector<Range>& rests, std::size_t block) {
  const auto n = static_cast<double>(block);
  std::vector<double> variances;
  for (const Range& rest : rests)
    for (std::size_t begin = rest.begin; begin + block <= rest.end; begin += block) {
      double mean = 0, squares = 0;
      for (std::size_t i = begin; i < begin + block; ++i) mean += readings[i] / n;
      for (std::size_t i = begin; i < begin + block; ++i) squares += (readings[i] - mean) * (readings[i] - mean);
      variances.push_back(squares / (n - 1));
    }
  if (variances.empty()) return std::numeric_limits<double>::infinity();
  const double of_median = std::pow(1 - 2 / (9 * (n - 1)), 3);  // a chi-square's over its mean (Wilson and Hilferty)
  return std::sqrt(median(std::move(variances)) / of_median);
}

}  // namespace imulab
