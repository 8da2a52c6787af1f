#include "imulab/estimate/kernel/slow_noise.hpp"

#include "imulab/model/sensor_noise.hpp"

#include <algorithm>
#include <cmath>

namespace imulab::kernel {

using Eigen::Index;

namespace {

/// The covariance of flicker and walk in the means over two times, by cells that are taken as their middles; far apart, one cell a time is exact
/// enough.
double covariance(const FlickerCovariance& flicker, double K, const TimeSpan& a, const TimeSpan& b) {
  const double longer = std::max(a.end - a.begin, b.end - b.begin);
  const int cells = std::abs(a.middle() - b.middle()) > 4 * longer ? 1 : 8;
  // Between two points of a cell, in the mean of the lag's logarithm, which flicker goes with.
  const double least_lag = std::exp(-1.5) * longer / cells;
  const auto time = [&](const TimeSpan& t, int cell) { return t.begin + (cell + 0.5) * (t.end - t.begin) / cells; };
  double sum = 0;
  for (int i = 0; i < cells; ++i)
    for (int j = 0; j < cells; ++j) {
      const double s = time(a, i), t = time(b, j);
      sum += flicker.between(std::max(least_lag, std::abs(s - t))) + K * K * std::min(s, t);
    }
  return sum / (cells * cells);
}

}  // namespace

Eigen::MatrixXd slow_noise(const std::vector<TimeSpan>& times, const NoiseModel& noise, double interval_s) {
  if (noise.B == 0 && noise.K == 0 && noise.R.value == 0) return {};
  const FlickerCovariance flicker(noise.B, interval_s);
  const auto n = std::ssize(times);
  Eigen::MatrixXd out(n, n);
  for (Index i = 0; i < n; ++i)
    for (Index j = 0; j <= i; ++j) {
      const TimeSpan &a = times[static_cast<std::size_t>(i)], &b = times[static_cast<std::size_t>(j)];
      const double duration = a.end - a.begin;
      const double stationary =
          i == j ? flicker.of_mean(duration) + noise.K * noise.K * (a.begin + duration / 3) : covariance(flicker, noise.K, a, b);
      out(i, j) = out(j, i) = stationary + noise.R.value * noise.R.value * a.middle() * b.middle();
    }
  return out;
}

}  // namespace imulab::kernel
