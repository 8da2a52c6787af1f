#include "imulab/rests.hpp"

#include "imulab/core/statistics.hpp"
#include "imulab/earth.hpp"
#include "imulab/error.hpp"
#include "imulab/recording.hpp"
#include "imulab/recording/rest_or_motion.hpp"
#include "imulab/recording/rests_of_view.hpp"
#include "imulab/session.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace imulab {

namespace {

constexpr std::size_t strides_per_window = 10;

/// Below this nothing is distinguished from a rest, however small the noise (of an ideal IMU): a hundredth of the Earth's rate, 1 ug, and the
/// rounding to whole counts.
double least_noise(std::string_view unit) {
  if (unit == "rad/s") return 7.3e-7;
  return unit == "m/s^2" ? 1e-5 : 0.3;
}

/// The axes of one triad, in windows that begin every `stride` samples.
struct WindowedTriad {
  const RecordingView& recording;
  std::size_t first_column, stride;
  double least;  ///< noise
};

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
        variances[j] = std::max(0.0, (q - s * s / n) / (n - 1)) + triad.least * triad.least;
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

/// One triad: the noise at rest of its axes, and which windows are quiet.
struct Quietness {
  std::array<double, 3> noise{};
  double factor = 0;
  std::vector<char> quiet;
};

/// The windows of `without`, by number, are not looked at for the thresholds.
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

/// Runs of quiet windows as sample ranges, cut at gaps and saturated samples. Where motion adjoins, one stride is trimmed: a quiet window may contain
/// its first, slow part.
std::vector<Range> quiet_runs(const RecordingView& recording, const std::vector<char>& quiet, std::size_t length, std::size_t stride) {
  std::vector<Range> runs;
  for (std::size_t k = 0; k < quiet.size();) {
    if (!quiet[k]) {
      ++k;
      continue;
    }
    std::size_t last = k;
    while (last + 1 < quiet.size() && quiet[last + 1]) ++last;
    Range run{(k + (k == 0 ? 0 : 1)) * stride, last * stride + length - (last + 1 == quiet.size() ? 0 : stride)};
    if (run.begin < run.end) runs.push_back(run);
    k = last + 1;
  }
  std::vector<Range> pieces;
  for (const Range& run : runs)
    for (const Range& piece : without_interruptions(recording, run, still_s)) pieces.push_back(piece);
  return pieces;
}

double mean_of(const RecordingView& recording, std::size_t column, Range range) {
  double sum = 0;
  std::vector<double> buffer;
  const double origin = recording.samples(column, {range.begin, range.begin + 1}, buffer)[0];
  for_each_block(recording, column, range, usual_block, [&](std::span<const double> samples) {
    for (const double sample : samples) sum += sample - origin;
  });
  return origin + sum / static_cast<double>(range.size());
}

/// The runs with a steady rotation: the gyros' mean is farther from the runs' median than rests differ.
std::vector<char> turning_runs(const RecordingView& recording, const std::vector<Range>& runs, const std::array<double, 3>& noise) {
  std::vector<char> turning(runs.size(), 0);
  if (runs.empty() || !recording.has(gyro_columns)) return turning;
  for (std::size_t j = 0; j < 3; ++j) {
    std::vector<double> means, weighted;
    for (const Range& run : runs) {
      means.push_back(mean_of(recording, gyro_columns + j, run));
      const auto copies = 1 + run.size() / (1 + runs.front().size() / 4);  // the median weighted by duration, coarsely
      weighted.insert(weighted.end(), std::min<std::size_t>(copies, 64), means.back());
    }
    const double center = median(weighted);
    // Rests differ by bias drift and g-sensitivity, which the robust width of the means measures; 5 noise sigmas of a single sample allow for few
    // rests. Read in SI, rests of good gyros differ by the Earth's rate, measured in different attitudes.
    const double earth = recording.gyro_unit == "rad/s" ? 2.5 * earth_rate : 0;
    const double allowed = std::max({10 * robust_sigma(weighted), 5 * noise[j], earth});
    for (std::size_t k = 0; k < runs.size(); ++k)
      if (std::abs(means[k] - center) > allowed) turning[k] = 1;
  }
  return turning;
}

/// For the means of ten strides from `first` on, half the mean square of successive differences over the variance about their mean (von Neumann's
/// ratio).
double smoothness(const RecordingView& recording, std::size_t column, std::size_t first, std::size_t stride, double least) {
  std::array<double, 10> mean{};
  std::vector<double> buffer;
  const std::span<const double> samples = recording.samples(column, {first, first + mean.size() * stride}, buffer);
  for (std::size_t s = 0; s < mean.size(); ++s) {
    const std::span<const double> part = samples.subspan(s * stride, stride);
    double sum = 0;
    for (const double sample : part) sum += sample - part[0];
    mean[s] = part[0] + sum / static_cast<double>(stride);
  }
  double center = 0, squares = 0, differences = 0;
  for (const double m : mean) center += m / 10;
  for (std::size_t s = 0; s < mean.size(); ++s) {
    squares += (mean[s] - center) * (mean[s] - center) / 9;
    if (s > 0) differences += (mean[s] - mean[s - 1]) * (mean[s] - mean[s - 1]) / 18;
  }
  return squares > least * least ? differences / squares : 1;
}

/// Do the readings of quiet windows vary smoothly, like motion? The ratio is 1 for noise, and near 0 for motion that is smooth over a window. Less
/// than the least noise is not motion.
bool quiet_is_motion(const RecordingView& recording, const std::vector<char>& quiet, std::size_t stride) {
  std::vector<double> ratios;
  const double least_gyro = least_noise(recording.gyro_unit), least_accel = least_noise(recording.accel_unit);
  const std::size_t step = 1 + quiet.size() / 2000;  // enough windows for a median
  for (std::size_t k = 0; k < quiet.size(); k += step) {
    if (!quiet[k]) continue;
    double sum = 0, axes = 0;
    for (const auto& [triad, least] : {std::pair(gyro_columns, least_gyro), std::pair(accel_columns, least_accel)})
      for (std::size_t axis = 0; axis < 3 && recording.has(triad); ++axis)
        sum += smoothness(recording, triad + axis, k * stride, stride, least), ++axes;
    ratios.push_back(sum / axes);
  }
  // Noise through a filter of a few hertz keeps 0.5; a turn at 500 deg/s has 0.1.
  return !ratios.empty() && median(ratios) < 0.25;
}

/// By the quietest windows that are not among `without`.
RestDetection rests_by_windows(const RecordingView& recording, const RestOptions& options, std::size_t stride, const std::vector<char>& without) {
  RestDetection found;
  const std::size_t length = strides_per_window * stride;
  const Quietness g = quietness_of({recording, gyro_columns, stride, least_noise(recording.gyro_unit)}, options.threshold_sigmas, without);
  const Quietness a = quietness_of({recording, accel_columns, stride, least_noise(recording.accel_unit)}, options.threshold_sigmas, without);
  std::vector<char> quiet(g.quiet.size());
  for (std::size_t k = 0; k < quiet.size(); ++k) quiet[k] = g.quiet[k] && a.quiet[k];

  if (quiet_is_motion(recording, quiet, stride)) {
    found.notes.push_back("no rests found: even the quietest stretches move smoothly");
    return found;
  }
  std::vector<Range> runs = quiet_runs(recording, quiet, length, stride);
  const auto shortest = static_cast<std::size_t>(options.shortest_s / recording.interval_s);
  std::erase_if(runs, [&](const Range& run) { return run.size() < std::max<std::size_t>(shortest, 2); });
  const std::vector<char> turning = turning_runs(recording, runs, g.noise);
  std::size_t longest_moving = 0;
  std::vector<Range> by_gyros;  // where they alone speak of motion
  for (std::size_t k = 0; k < runs.size(); ++k) {
    if (turning[k]) {
      ++found.turning;
    } else if (std::string motion = motion_in(recording, runs[k]); !motion.empty()) {
      ++found.moving;
      if (motion_by_force(recording, runs[k]).empty()) by_gyros.push_back(runs[k]);
      if (runs[k].size() > longest_moving) longest_moving = runs[k].size(), found.motion = std::move(motion);
    } else {
      found.rests.push_back(runs[k]);
    }
  }
  constexpr std::size_t several = 3;
  if (found.rests.empty() && by_gyros.size() >= several && by_gyros.size() == found.moving) {
    found.rests = std::move(by_gyros);  // the gyros are in another unit: the turns between the rests will tell
    found.moving = 0, found.motion.clear();
  }
  found.gyro_noise = g.noise;
  found.accel_noise = a.noise;
  found.gyro_factor = g.factor;
  found.accel_factor = a.factor;
  found.notes.push_back(fmt::format(
      "{} rests found ({:g} s windows; thresholds from the recording: {:.2f} times the gyros' and {:.2f} times the accelerometers' noise)",
      found.rests.size(), options.window_s, g.factor, a.factor));
  if (found.moving > 0) found.notes.push_back(fmt::format("{} quiet stretches were rejected as rests: {}", found.moving, found.motion));
  if (found.turning > 0) found.notes.push_back(fmt::format("{} quiet stretches were rejected as rests: the IMU was turning steadily", found.turning));
  return found;
}

/// True if these stretches show gravity: of one length, unchanged within each, and in several directions far from the first. Those of a hand's pauses
/// do. A vehicle that runs smoothly stays level, and where it does not, other forces than gravity act.
bool are_pauses(const RecordingView& recording, const std::vector<Range>& rests) {
  constexpr std::size_t several = 5;
  constexpr double far_away = 0.5;  // of the length: half a radian
  constexpr double alike = 0.15;    // lengths, with the zeros and scales of an uncalibrated sensor
  constexpr double steady = 0.05;   // between halves: 3 degrees, which a hand drifts by in seconds
  const auto force = [&](const Range& part) {
    return Vector3d(mean_of(recording, accel_columns, part), mean_of(recording, accel_columns + 1, part),
                    mean_of(recording, accel_columns + 2, part));
  };
  if (rests.empty()) return false;
  const Vector3d first = force(rests.front());
  std::size_t away = 0, moving = 0;
  for (const Range& rest : rests) {
    const std::size_t middle = rest.begin + rest.size() / 2;
    const Vector3d before = force({rest.begin, middle}), behind = force({middle, rest.end}), mean = 0.5 * (before + behind);
    const bool moves = std::abs(mean.norm() - first.norm()) > alike * first.norm() || (behind - before).norm() > steady * first.norm();
    moving += moves;
    away += !moves && (mean - first).norm() > far_away * first.norm();
  }
  return away >= several && 4 * moving <= rests.size();
}

/// The windows that overlap a rest.
std::vector<char> windows_in(const std::vector<Range>& rests, std::size_t windows, std::size_t stride) {
  std::vector<char> inside(windows, 0);
  for (const Range& rest : rests)
    for (std::size_t k = 0; k < windows; ++k)
      if ((k + strides_per_window) * stride > rest.begin && k * stride < rest.end) inside[k] = 1;
  return inside;
}

}  // namespace

RestDetection detect_rests(const Recording& recording, const RestOptions& options) {
  validate(recording);
  return detect_rests(RecordingView(recording), options);
}

RestDetection detect_rests(const RecordingView& recording, const RestOptions& options) {
  for (const double option : {options.window_s, options.shortest_s, options.threshold_sigmas})
    if (!(option > 0 && std::isfinite(option))) throw Error(fmt::format("rests: {} as an option; expected more than 0", option));
  const auto stride = static_cast<std::size_t>(std::max(1.0, std::round(options.window_s / strides_per_window / recording.interval_s)));
  if (recording.size() < 2 * strides_per_window * stride) return {};
  RestDetection found = rests_by_windows(recording, options, stride, {});
  // A rest on a desk is stiller than pauses in a hand: where it is nearly all that was found, thresholds come from the rest of the recording, too.
  constexpr std::size_t few = 3, several = 20 * strides_per_window;
  if (found.rests.empty() || found.rests.size() > few || !recording.has(accel_columns)) return found;
  const std::vector<char> still = windows_in(found.rests, recording.size() / stride + 1 - strides_per_window, stride);
  if (std::count(still.begin(), still.end(), 0) < static_cast<std::ptrdiff_t>(several)) return found;
  RestDetection pauses = rests_by_windows(recording, options, stride, still);
  if (!are_pauses(recording, pauses.rests)) return found;
  pauses.notes.push_back(
      fmt::format("{} of them are stiller than the others, whose noise is that of a hand: thresholds are those of its pauses", found.rests.size()));
  return pauses;
}

}  // namespace imulab
