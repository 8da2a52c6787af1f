#include "imulab/recording/quiet_windows.hpp"

#include "imulab/core/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <string_view>
#include <utility>

namespace imulab {

namespace {

/// Of an ideal IMU: a hundredth of the Earth's rate, 1 ug, and the rounding to whole counts.
double least_noise_of_unit(std::string_view unit) {
  if (unit == "rad/s") return 7.3e-7;
  return unit == "m/s^2" ? 1e-5 : 0.3;
}

/// The step of readings that are rounded: the least change from one to the next, but for one in a thousand, as samples that were filled in are. Of
/// fine readings it is far below their noise. From parts of a long column; 0 where it never changes.
double smallest_change(const RecordingView& recording, std::size_t column) {
  constexpr std::size_t parts = 50, length = 400;
  const std::size_t every = std::max(length, recording.size() / parts);
  std::vector<double> changes, buffer;
  for (std::size_t begin = 0; begin < recording.size(); begin += every) {
    const std::span<const double> part = recording.samples(column, {begin, std::min(recording.size(), begin + length)}, buffer);
    for (std::size_t i = 1; i < part.size(); ++i)
      if (part[i] != part[i - 1]) changes.push_back(std::abs(part[i] - part[i - 1]));
  }
  if (changes.empty()) return 0;
  const auto at = changes.begin() + static_cast<std::ptrdiff_t>(changes.size() / 1000);
  std::nth_element(changes.begin(), at, changes.end());
  return *at;
}

/// Calls `each`(k, variances) for every window, with the variance of each axis and the least noise's added. One pass over the samples in blocks,
/// which takes no memory: it is made again rather than kept.
template <class Each>
void for_each_window(const WindowedTriad& triad, const Each& each) {
  // Sums of strides, combined about a local origin: no cancellation for raw counts far from zero.
  const RecordingView& recording = triad.recording;
  const std::size_t stride = triad.stride, strides = recording.size() / stride, block = std::max(stride, usual_block / stride * stride);
  const double n = static_cast<double>(strides_per_window * stride);
  struct Axis {
    double origin = 0;
    std::array<double, strides_per_window> sum{}, square{};  // of the last strides, the k-th in place k % strides_per_window
    std::vector<double> buffer;
    std::span<const double> samples;
  };
  std::array<Axis, 3> axes;
  for (std::size_t j = 0; j < 3; ++j) axes[j].origin = recording.samples(triad.first_column + j, {0, 1}, axes[j].buffer)[0];
  for (std::size_t begin = 0, k = 0; begin < strides * stride; begin += block) {
    const Range range{begin, std::min(strides * stride, begin + block)};
    for (std::size_t j = 0; j < 3; ++j) axes[j].samples = recording.samples(triad.first_column + j, range, axes[j].buffer);
    for (std::size_t at = 0; at < range.size(); at += stride, ++k) {
      for (Axis& axis : axes) {
        double s = 0, q = 0;
        for (const double sample : axis.samples.subspan(at, stride)) {
          const double d = sample - axis.origin;
          s += d;
          q += d * d;
        }
        axis.sum[k % strides_per_window] = s;
        axis.square[k % strides_per_window] = q;
      }
      if (k + 1 < strides_per_window) continue;
      std::array<double, 3> variances{};
      for (std::size_t j = 0; j < 3; ++j) {
        double s = 0, q = 0;
        for (std::size_t i = k + 1; i < k + 1 + strides_per_window; ++i) {  // from the oldest on
          s += axes[j].sum[i % strides_per_window];
          q += axes[j].square[i % strides_per_window];
        }
        variances[j] = std::max(0.0, (q - s * s / n) / (n - 1)) + triad.least[j] * triad.least[j];
      }
      each(k + 1 - strides_per_window, variances);
    }
  }
}

/// Half-sample mode (Bickel and Fruehwirth 2006): the center of the densest part of a sorted sample.
double half_sample_mode(const std::vector<double>& sorted) {
  std::size_t begin = 0, end = sorted.size();
  while (end - begin > 3) {
    const std::size_t half = (end - begin + 1) / 2;
    std::size_t best = begin;
    for (std::size_t i = begin; i + half <= end; ++i)
      if (sorted[i + half - 1] - sorted[i] < sorted[best + half - 1] - sorted[best]) best = i;
    begin = best;
    end = best + half;
  }
  return sorted[begin + (end - begin) / 2];
}

/// The dense cluster of a sample of logarithms: its median, and its robust width from the side below, which motion cannot reach.
struct Cluster {
  double center = 0, width = 0;
};

Cluster cluster_of(std::vector<double> logs) {
  std::sort(logs.begin(), logs.end());
  const double mode = half_sample_mode(logs);
  std::erase_if(logs, [&](double x) { return std::abs(x - mode) > 1; });  // the mode scatters by less; motion is farther away
  Cluster cluster{median(logs), 0};
  std::erase_if(logs, [&](double x) { return x > cluster.center; });
  for (double& x : logs) x = cluster.center - x;
  cluster.width = 1.4826 * median(logs);
  return cluster;
}

}  // namespace

double least_noise(const RecordingView& recording, std::size_t column) {
  constexpr double between_steps = 0.6;  // of a step: readings that change between two scatter by a half, times sqrt(n / (n - 1)) of few
  const double ideal = least_noise_of_unit(column < accel_columns ? recording.gyro_unit : recording.accel_unit);
  return recording.has(column) ? std::max(ideal, between_steps * smallest_change(recording, column)) : ideal;
}

Quietness quietness_of(const WindowedTriad& triad, double threshold_sigmas, const std::vector<char>& without) {
  Quietness result;
  if (!triad.recording.has(triad.first_column)) {
    result.quiet.assign(triad.recording.size() / triad.stride + 1 - strides_per_window, 1);
    return result;
  }
  std::vector<std::array<double, 3>> apart;  // windows that do not overlap
  for_each_window(triad, [&](std::size_t k, const std::array<double, 3>& variances) {
    if (k % strides_per_window == 0 && (without.empty() || !without[k])) apart.push_back(variances);
  });
  std::vector<double> logs(apart.size());
  for (std::size_t j = 0; j < 3; ++j) {
    for (std::size_t k = 0; k < apart.size(); ++k) logs[k] = 0.5 * std::log(apart[k][j]);
    result.noise[j] = std::exp(cluster_of(logs).center);
  }
  // ln of the RMS over the axes of (standard deviation / noise): 0 in the middle of the rest cluster.
  const auto level = [&](const std::array<double, 3>& variances) {
    double sum = 0;
    for (std::size_t j = 0; j < 3; ++j) sum += variances[j] / (result.noise[j] * result.noise[j]);
    return 0.5 * std::log(sum / 3);
  };
  for (std::size_t k = 0; k < apart.size(); ++k) logs[k] = level(apart[k]);
  const Cluster cluster = cluster_of(std::move(logs));
  const double length = static_cast<double>(strides_per_window * triad.stride);
  const double white = 1 / std::sqrt(6 * (length - 1));  // width of the cluster for white noise on three axes
  const double threshold = cluster.center + threshold_sigmas * std::max(cluster.width, white);
  result.factor = std::exp(threshold);
  result.quiet.reserve(triad.recording.size() / triad.stride);
  for_each_window(triad, [&](std::size_t, const std::array<double, 3>& variances) { result.quiet.push_back(level(variances) <= threshold); });
  return result;
}

}  // namespace imulab
