#include "imulab/rests.hpp"

#include "imulab/core/statistics.hpp"
#include "imulab/earth.hpp"
#include "imulab/error.hpp"
#include "imulab/recording.hpp"
#include "imulab/recording/lost_rests.hpp"
#include "imulab/recording/quiet_windows.hpp"
#include "imulab/recording/rest_or_motion.hpp"
#include "imulab/session.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace imulab {

namespace {

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

Vector3d force_over(const RecordingView& recording, const Range& range) {
  return {mean_of(recording, accel_columns, range), mean_of(recording, accel_columns + 1, range), mean_of(recording, accel_columns + 2, range)};
}

enum class GyroLevel { usual, turning, shifted };

/// The runs in which the gyros' mean is farther from the runs' median than rests differ. Accelerometers that stay quiet meanwhile leave one steady
/// turn, that about the vertical: where the difference is along another direction, the gyros' zero is another. In counts that is not told.
std::vector<GyroLevel> gyro_levels(const RecordingView& recording, const std::vector<Range>& runs, const std::array<double, 3>& noise) {
  constexpr double along = 0.95;  // cosine: 18 degrees, for zeros and axes that are not calibrated
  std::vector<GyroLevel> levels(runs.size(), GyroLevel::usual);
  if (runs.empty() || !recording.has(gyro_columns)) return levels;
  std::vector<Vector3d> apart(runs.size());
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
    for (std::size_t k = 0; k < runs.size(); ++k) {
      apart[k][static_cast<Eigen::Index>(j)] = means[k] - center;
      if (std::abs(means[k] - center) > allowed) levels[k] = GyroLevel::turning;
    }
  }
  if (recording.gyro_unit != "rad/s" || !recording.has(accel_columns)) return levels;
  for (std::size_t k = 0; k < runs.size(); ++k) {
    if (levels[k] == GyroLevel::usual) continue;
    const Vector3d force = force_over(recording, runs[k]);
    if (std::abs(apart[k].dot(force)) < along * apart[k].norm() * force.norm()) levels[k] = GyroLevel::shifted;
  }
  return levels;
}

/// Parts of one run have the level of one that is as usual: their gyros drift with the temperature.
void take_levels_of_neighbors(const RecordingView& recording, const std::vector<Range>& runs, std::vector<GyroLevel>& levels) {
  const auto take = [&](std::size_t k, std::size_t from) {
    const Range &first = runs[std::min(k, from)], &second = runs[std::max(k, from)];
    if (levels[from] == GyroLevel::usual && first.end == second.begin && recording.gaps_in({second.begin, second.begin + 1}) == 0)
      levels[k] = GyroLevel::usual;
  };
  for (std::size_t k = 1; k < runs.size(); ++k) take(k, k - 1);
  for (std::size_t k = runs.size(); k-- > 1;) take(k - 1, k);
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
bool quiet_is_motion(const RecordingView& recording, const std::vector<char>& quiet, std::size_t stride, const std::array<double, 6>& least) {
  std::vector<double> ratios;
  const std::size_t step = 1 + quiet.size() / 2000;  // enough windows for a median
  for (std::size_t k = 0; k < quiet.size(); k += step) {
    if (!quiet[k]) continue;
    double sum = 0, axes = 0;
    for (std::size_t column = 0; column < least.size(); ++column)
      if (recording.has(column)) sum += smoothness(recording, column, k * stride, stride, least[column]), ++axes;
    ratios.push_back(sum / axes);
  }
  // Noise through a filter of a few hertz keeps 0.5; a turn at 500 deg/s has 0.1.
  return !ratios.empty() && median(ratios) < 0.25;
}

/// Cuts runs in which the thermal reading changes by more than two parts into parts: biases follow it, and the mean of the whole run has that of no
/// temperature. Gyros and accelerometers at one board share the first thermometer found.
std::vector<Range> cut_by_temperature(const RecordingView& recording, const std::vector<Range>& runs, double part) {
  constexpr double block_s = 5, noises = 10;  // thermometers are noisy or coarse
  if (!std::isfinite(part)) return runs;
  const std::size_t column = recording.has(accel_temperature_columns) ? accel_temperature_columns : gyro_temperature_columns;
  if (!recording.has(column)) return runs;
  const auto block = std::max<std::size_t>(1, static_cast<std::size_t>(block_s / recording.interval_s));
  std::vector<Range> out;
  for (const Range& run : runs) {
    std::vector<double> means;
    for (std::size_t at = run.begin; at + block <= run.end; at += block)
      means.push_back(mean_of(recording, column, {at, at + block}));
    std::vector<double> steps;
    for (std::size_t k = 1; k < means.size(); ++k) steps.push_back(std::abs(means[k] - means[k - 1]));
    const auto [low, high] = means.empty() ? std::pair(0., 0.) : std::pair(*std::ranges::min_element(means), *std::ranges::max_element(means));
    if (!(high - low > 2 * part) || !(high - low > noises * median(steps))) {
      out.push_back(run);
      continue;
    }
    std::size_t begin = 0;
    for (std::size_t k = 1; k <= means.size(); ++k) {
      if (k < means.size() && std::abs(means[k] - means[begin]) < part) continue;
      out.push_back({run.begin + begin * block, k < means.size() ? run.begin + k * block : run.end});
      begin = k;
    }
  }
  return out;
}

struct QuietRuns : RestDetection {
  std::size_t shifted = 0;  ///< as LostRests has it
};

/// By the quietest windows that are not among `without`.
QuietRuns rests_by_windows(const RecordingView& recording, const RestOptions& options, std::size_t stride, const std::vector<char>& without) {
  QuietRuns found;
  const std::size_t length = strides_per_window * stride;
  std::array<double, 6> least{};
  for (std::size_t column = 0; column < least.size(); ++column) least[column] = least_noise(recording, column);
  const Quietness g = quietness_of({recording, gyro_columns, stride, {least[0], least[1], least[2]}}, options.threshold_sigmas, without);
  const Quietness a = quietness_of({recording, accel_columns, stride, {least[3], least[4], least[5]}}, options.threshold_sigmas, without);
  std::vector<char> quiet(g.quiet.size());
  for (std::size_t k = 0; k < quiet.size(); ++k) quiet[k] = g.quiet[k] && a.quiet[k];

  if (quiet_is_motion(recording, quiet, stride, least)) {
    found.notes.push_back("no rests found: even the quietest stretches move smoothly");
    return found;
  }
  std::vector<Range> runs = cut_by_temperature(recording, quiet_runs(recording, quiet, length, stride), options.part);
  const auto shortest = static_cast<std::size_t>(options.shortest_s / recording.interval_s);
  std::erase_if(runs, [&](const Range& run) { return run.size() < std::max<std::size_t>(shortest, 2); });
  std::vector<GyroLevel> levels = gyro_levels(recording, runs, g.noise);
  take_levels_of_neighbors(recording, runs, levels);
  std::size_t longest_moving = 0;
  std::vector<Range> by_gyros;  // where they alone speak of motion
  for (std::size_t k = 0; k < runs.size(); ++k) {
    if (levels[k] != GyroLevel::usual) {
      ++(levels[k] == GyroLevel::turning ? found.turning : found.shifted);
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
  if (found.shifted > 0)
    found.notes.push_back(
        fmt::format("{} quiet stretches were rejected as rests: the gyros read another rate, not about the vertical", found.shifted));
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
  if (rests.empty()) return false;
  const Vector3d first = force_over(recording, rests.front());
  std::size_t away = 0, moving = 0;
  for (const Range& rest : rests) {
    const std::size_t middle = rest.begin + rest.size() / 2;
    const Vector3d before = force_over(recording, {rest.begin, middle}), behind = force_over(recording, {middle, rest.end}),
                   mean = 0.5 * (before + behind);
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
  LostRests lost;
  return detect_rests(recording, options, lost);
}

RestDetection detect_rests(const RecordingView& recording, const RestOptions& options, LostRests& lost) {
  for (const double option : {options.window_s, options.shortest_s, options.threshold_sigmas})
    if (!(option > 0 && std::isfinite(option))) throw Error(fmt::format("rests: {} as an option; expected more than 0", option));
  const auto stride = static_cast<std::size_t>(std::max(1.0, std::round(options.window_s / strides_per_window / recording.interval_s)));
  if (recording.size() < 2 * strides_per_window * stride) return {};
  QuietRuns found = rests_by_windows(recording, options, stride, {});
  lost = {found.moving, found.shifted, found.motion};
  // A rest on a desk is stiller than pauses in a hand: where it is nearly all that was found, thresholds come from the rest of the recording, too.
  constexpr std::size_t few = 3, several = 20 * strides_per_window;
  if (found.rests.empty() || found.rests.size() > few || !recording.has(accel_columns)) return found;
  const std::vector<char> still = windows_in(found.rests, recording.size() / stride + 1 - strides_per_window, stride);
  if (std::count(still.begin(), still.end(), 0) < static_cast<std::ptrdiff_t>(several)) return found;
  QuietRuns pauses = rests_by_windows(recording, options, stride, still);
  if (!are_pauses(recording, pauses.rests)) return found;
  lost = {pauses.moving, pauses.shifted, pauses.motion};
  pauses.notes.push_back(
      fmt::format("{} of them are stiller than the others, whose noise is that of a hand: thresholds are those of its pauses", found.rests.size()));
  return pauses;
}

}  // namespace imulab
