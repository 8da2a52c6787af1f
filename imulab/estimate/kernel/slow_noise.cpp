#include "imulab/estimate/kernel/slow_noise.hpp"

#include "imulab/model/sensor_noise.hpp"

#include <algorithm>
#include <cmath>

namespace imulab::kernel {

using Eigen::Index;

namespace {

/// Returns the covariance of flicker and random walk between the means over two times, with cells represented by their middles. If the times are far
/// apart, one cell each is accurate enough.
double covariance(const FlickerCovariance& flicker, double K, const TimeSpan& a, const TimeSpan& b) {
  const double longer = std::max(a.end - a.begin, b.end - b.begin);
  const int cells = std::abs(a.middle() - b.middle()) > 4 * longer ? 1 : 8;
  // The effective lag within a cell is the mean of the logarithm of the lag, on which flicker depends.
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
