#include "imulab/recording/rest_means.hpp"

#include "imulab/core/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
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

std::vector<RestMeans> summarize_rests(const Recording& recording, const std::vector<Range>& ranges) {
  std::vector<RestMeans> rests;
  for (const Range& range : ranges)
    rests.push_back({range, 0.5 * (recording.time_s(range.begin) + recording.time_s(range.end - 1)), mean_of(recording.accel, range),
                     mean_of(recording.gyro, range), recording.time_s(range.begin) - recording.interval_s, recording.time_s(range.end - 1)});
  return rests;
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
