#include "imulab/estimate/kernel/rest_means.hpp"

#include <cmath>

namespace imulab::kernel {

namespace {

double mean_of(const std::vector<double>& column, Range range) {
  const double origin = column[range.begin];  // sums stay small next to raw counts
  double sum = 0;
  for (std::size_t i = range.begin; i < range.end; ++i) sum += column[i] - origin;
  return origin + sum / static_cast<double>(range.size());
}

double squares_about(const std::vector<double>& column, Range range, double mean) {
  double sum = 0;
  for (std::size_t i = range.begin; i < range.end; ++i) sum += (column[i] - mean) * (column[i] - mean);
  return sum;
}

}  // namespace

std::vector<Rest> summarize_rests(const Recording& recording, const std::vector<Range>& ranges) {
  std::vector<Rest> rests;
  for (const Range& range : ranges) {
    Rest rest;
    rest.range = range;
    rest.mid_s = 0.5 * (recording.time_s(range.begin) + recording.time_s(range.end - 1));
    for (int j = 0; j < 3; ++j) {
      rest.accel[j] = mean_of(recording.accel[j], range);
      rest.gyro[j] = mean_of(recording.gyro[j], range);
    }
    rests.push_back(rest);
  }
  return rests;
}

SampleNoise measure_noise(const Recording& recording, const std::vector<Rest>& rests) {
  Vector3d accel = Vector3d::Zero(), gyro = Vector3d::Zero();
  double degrees = 0;
  for (const Rest& rest : rests) {
    for (int j = 0; j < 3; ++j) {
      accel[j] += squares_about(recording.accel[j], rest.range, rest.accel[j]);
      gyro[j] += squares_about(recording.gyro[j], rest.range, rest.gyro[j]);
    }
    degrees += static_cast<double>(rest.range.size()) - 1;
  }
  return {(accel / std::max(degrees, 1.0)).cwiseSqrt(), (gyro / std::max(degrees, 1.0)).cwiseSqrt()};
}

}  // namespace imulab::kernel
