#include "imulab/core/statistics.hpp"
#include "imulab/error.hpp"
#include "imulab/noise/moving.hpp"
#include "imulab/noise/moving_slow.hpp"
#include "imulab/noise/moving_spectrum.hpp"
#include "imulab/noise/still_part.hpp"
#include "imulab/recording/clock.hpp"
#include "imulab/recording/recording_view.hpp"
#include "imulab/recording/resampling.hpp"
#include "imulab/recording/rest_or_motion.hpp"
#include "imulab/recording/validate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace imulab {
namespace {

using noise::FactorRange, noise::MovingSpectrum, noise::SlowParts;

constexpr double shortest_moving_s = 30, long_log_s = 64;
constexpr std::size_t few_groups = 5, many_groups = 8;

/// A log with vibration or in motion, and the parts of it that are used.
struct MovingLog {
  RecordingView view;
  Range range;  ///< without gaps
  std::size_t groups = many_groups;
  bool moves = false;
  double vibration_hz = 1, stamps_s = 0;
  std::optional<SlowParts> slow;

  double seconds() const { return static_cast<double>(range.size()) * view.interval_s; }
};

/// RMS of the stamps about lines through 128 of them each: a clock that wanders slowly is no jitter.
double stamp_scatter(const RecordingView& view, const Range& range) {
  constexpr std::size_t block = 128;
  double squares = 0, freedom = 0;
  for (std::size_t begin = range.begin; begin + block <= range.end; begin += block) {
    const double n = block, middle = 0.5 * (n - 1);
    double sum = 0, product = 0, square = 0;
    for (std::size_t j = 0; j < block; ++j) {
      const double late = 1e-9 * static_cast<double>(view.time_ns[begin + j] - view.time_ns[begin]) - view.interval_s * static_cast<double>(j);
      sum += late, product += (static_cast<double>(j) - middle) * late, square += late * late;
    }
    squares += square - sum * sum / n - product * product * 12 / (n * (n * n - 1)), freedom += n - 2;
  }
  return freedom > 0 ? std::sqrt(std::max(0.0, squares) / freedom) : 0;
}

Range longest_without_gap(const RecordingView& view, const Range& within) {
  Range longest, now{within.begin, within.begin};
  for (std::size_t i = within.begin; i < within.end; now.end = ++i)
    if (std::ranges::binary_search(view.gaps, i)) {
      if (now.size() > longest.size()) longest = now;
      now = {i, i};
    }
  return now.size() > longest.size() ? now : longest;
}

bool moves_in(const RecordingView& view, const Range& range, std::size_t groups) {
  for (std::size_t g = 0; g < groups; ++g)
    if (!motion_in(view, {range.begin + g * range.size() / groups, range.begin + (g + 1) * range.size() / groups}, true).empty()) return true;
  return false;
}

std::size_t column_of(const NoiseAxis& axis) {
  return (axis.name.starts_with("gyro") ? gyro_columns : accel_columns) + static_cast<std::size_t>(axis.name.back() - 'x');
}

/// True if every axis scatters in the range at most one and a half times as much as at rest.
bool is_quiet(const NoiseAnalysis& rest, const RecordingView& view, const Range& range) {
  constexpr double most = 1.5 * 1.5;
  std::vector<double> buffer;
  for (const NoiseAxis& axis : rest.axes) {
    if (!axis.fit || !view.has(column_of(axis))) continue;
    const double step = axis.fit->resolution, N = axis.fit->N.value;
    double sum = 0, square = 0;
    const std::span<const double> samples = view.samples(column_of(axis), range, buffer);
    for (const double s : samples) sum += s - samples[0], square += (s - samples[0]) * (s - samples[0]);
    const double n = static_cast<double>(samples.size());
    if (square / n - sum * sum / (n * n) > most * (N * N / view.interval_s + step * step / 12)) return false;
  }
  return true;
}

/// The rests at begin and end of a log that moves in between: as quiet as the log at rest. The second next to the motion is left
/// out. Nothing if either is too short.
std::optional<SlowParts> rests_at_ends(const NoiseAnalysis& rest, const RecordingView& view) {
  constexpr std::size_t fewest_samples_of_window = 50;
  constexpr double shortest_rest_s = 5;
  const auto window = std::max(fewest_samples_of_window, static_cast<std::size_t>(1 / view.interval_s));
  const std::size_t windows = view.size() / window;
  const auto quiet_from = [&](auto window_at) {
    std::size_t quiet = 0;
    while (quiet < windows && is_quiet(rest, view, window_at(quiet))) ++quiet;
    return (std::max<std::size_t>(quiet, 1) - 1) * window;
  };
  const std::size_t n = view.size();
  const std::size_t first = quiet_from([&](std::size_t k) { return Range{k * window, (k + 1) * window}; });
  const std::size_t last = quiet_from([&](std::size_t k) { return Range{n - (k + 1) * window, n - k * window}; });
  const SlowParts out{{0, first}, {n - last, n}};
  for (const Range& range : {out.first, out.second})
    if (static_cast<double>(range.size()) * view.interval_s < shortest_rest_s || !motion_in(view, range, true).empty()) return std::nullopt;
  return out;
}

/// Uses the longest part without a gap; of a log that moves, the part between its rests at begin and end.
MovingLog examined(const NoiseAnalysis& rest, const RecordingView& view) {
  MovingLog log{.view = view, .range = longest_without_gap(view, {0, view.size()})};
  log.groups = log.seconds() < long_log_s ? few_groups : many_groups;
  log.moves = log.range.size() > 0 && moves_in(view, log.range, log.groups);
  if (log.moves) {
    log.slow = rests_at_ends(rest, view);
    Range middle{0, view.size()};
    if (log.slow) middle = {log.slow->first.end, log.slow->second.begin};
    log.range = longest_without_gap(view, middle);
  } else {
    log.slow = SlowParts{log.range, {}};
  }
  if (log.range.size() > 1)
    log.view.interval_s = (view.time_s(log.range.end - 1) - view.time_s(log.range.begin)) / static_cast<double>(log.range.size() - 1);
  if (!(log.seconds() >= shortest_moving_s))
    throw Unsupported(fmt::format("{}: has {:.3g} s{} without a gap; expected at least {:g} s after --moving", view.name, log.seconds(),
                                  log.moves ? " of motion" : "", shortest_moving_s));
  log.groups = log.seconds() < long_log_s ? few_groups : many_groups;
  if (log.moves) log.vibration_hz = std::min(10.0, 0.25 / log.view.interval_s);
  log.stamps_s = stamp_scatter(log.view, log.range);
  return log;
}

void expect_comparable(const NoiseAnalysis& rest, const MovingLog& log) {
  const double hz = 1 / log.view.interval_s;
  if (rest.interval_s > 0 && !same_interval(log.view.interval_s, rest.interval_s))
    throw Error(fmt::format("{}: has {:.4g} Hz, {} {:.4g} Hz, and the noise of a reading depends on the rate; expected logs of one rate",
                            log.view.name, hz, rest.recording, 1 / rest.interval_s));
  bool common = false;
  for (const NoiseAxis& axis : rest.axes) {
    const std::size_t column = column_of(axis);
    if (!log.view.has(column)) continue;
    common = true;
    const std::string_view unit = column < accel_columns ? log.view.gyro_unit : log.view.accel_unit;
    if (unit != axis.unit)
      throw Error(fmt::format("{}: {} is in {}, in {} in {}; expected one unit: declare it, for example --set {}.unit={}", log.view.name, axis.name,
                              unit, rest.recording, axis.unit, column < accel_columns ? "gyro" : "accel", column < accel_columns ? "deg/s" : "g"));
  }
  if (!common)
    throw Error(fmt::format("{}: has no triad in common with {}; expected gyros or accelerometers in both", log.view.name, rest.recording));
}

/// sqrt(1 + variance / reference) for a mean of groups.
NoiseCoefficient added_factor(const noise::GroupMean& variance, double reference) {
  const auto factor = [&](double v) { return std::sqrt(1 + std::max(0.0, v) / reference); };
  return noise::determined_factor({factor(variance.value), factor(variance.value - variance.margin), factor(variance.value + variance.margin)});
}

/// The root of a ratio of densities, with the uncertainty of N at rest.
NoiseCoefficient ratio_factor(const noise::GroupMean& ratio, const NoiseCoefficient& N) {
  const double relative = N.determined && std::isfinite(N.standard_uncertainty) ? 2 * 1.96 * N.standard_uncertainty / N.value : 0;
  const double margin = std::hypot(ratio.margin, relative * ratio.value), value = std::sqrt(ratio.value);
  return {value, 0.5 * std::hypot(ratio.sigma, relative / 1.96 * ratio.value) / value, std::sqrt(std::max(0.0, ratio.value - margin)),
          std::sqrt(ratio.value + margin), true};
}

MovingCause caused(const char* name, const char* parameter, NoiseCoefficient factor, double size) {
  return {.name = name, .parameter = parameter, .factor = factor, .size = size};
}

/// Causes in the spectrum: equations (1) to (4).
std::vector<MovingCause> spectral_causes(const NoiseFit& rest, const MovingLog& log, const MovingSpectrum& s) {
  const double N = rest.N.value, T = log.view.interval_s, reference = s.floor.value * N * N / T;
  std::vector<MovingCause> out;
  out.push_back(caused("white", "N", ratio_factor(s.floor, rest.N), std::sqrt(s.floor.value) * N));
  out.push_back(caused("vibration", "N", added_factor(s.vibration, reference), std::sqrt(std::max(0.0, s.vibration.value))));
  if (s.vibration.value > s.vibration.margin) out.back().hz = s.strongest_hz;
  if (log.moves) {
    out.back().reason = fmt::format("above {:.3g} Hz: below, it cannot be separated from motion", log.vibration_hz);
    out.push_back({.name = "below 1 Hz", .parameter = "N", .reason = "the log moves: its low frequencies are motion"});
  } else if (s.slow) {
    out.push_back(caused("below 1 Hz", "N", ratio_factor(*s.slow, rest.N), std::sqrt(s.slow->value) * N));
  } else {
    out.push_back({.name = "below 1 Hz", .parameter = "N", .reason = "the log is too short for its rate"});
  }
  const double square = log.stamps_s * log.stamps_s;
  const noise::GroupMean jitter{square * s.derivative.value, square * s.derivative.sigma, square * s.derivative.margin};
  out.push_back(caused("stamps", "N", added_factor(jitter, reference), std::sqrt(std::max(0.0, jitter.value))));
  out.back().stamps_s = log.stamps_s;
  return out;
}

/// All causes of one axis; `quieter` becomes true if the log scatters less than that at rest.
MovingAxis axis_causes(const NoiseAnalysis& rest, const NoiseAxis& axis, const MovingLog& log, std::span<const double> readings, bool& quieter) {
  MovingAxis out{.name = axis.name, .unit = axis.unit};
  const std::size_t column = column_of(axis);
  if (std::ranges::all_of(readings, [&](double r) { return r == readings[0]; }))
    throw Unsupported(fmt::format("{}: all readings of {} are equal: no noise can be seen", log.view.name, axis.name));
  const MovingSpectrum s = noise::moving_spectrum(readings, log.view.interval_s, *axis.fit, log.vibration_hz, log.groups);
  constexpr double clearly = 0.64;  // 0.8 of the scatter
  quieter = s.scatter.value + s.scatter.margin < clearly;
  out.causes = spectral_causes(*axis.fit, log, s);
  if (log.moves)
    out.causes.push_back(
        {.name = "rectification", .parameter = "bias", .reason = "the log moves: expected a log at the attitude of the one at rest"});
  else
    out.causes.push_back(noise::rectification_cause(rest, axis, log.view, column, log.range, s.floor.value));
  if (log.slow)
    out.causes.push_back(noise::drift_cause(axis, log.view, column, *log.slow, s.floor.value));
  else
    out.causes.push_back({.name = "drift", .parameter = "K", .reason = "the log moves, and its begin and end are not as quiet as the log at rest"});
  for (MovingCause& cause : out.causes) cause.file = log.view.name;
  return out;
}

}  // namespace

MovingEvidence moving_log(const NoiseAnalysis& rest, Recording recording) {
  validate(recording);
  if (worth_filling(recording)) recording = with_short_gaps_filled(std::move(recording)).recording;
  const MovingLog log = examined(rest, recording);
  expect_comparable(rest, log);
  MovingEvidence out;
  out.file = fmt::format("{}: {}, {:.4g} s at {:.4g} Hz", recording.name, log.moves ? "moves" : "at rest", log.seconds(), 1 / log.view.interval_s);
  std::size_t quieter_axes = 0;
  for (const NoiseAxis& axis : rest.axes) {
    if (!axis.fit || !axis.fit->N.determined || !log.view.has(column_of(axis))) continue;
    std::vector<double> buffer;
    const std::span<const double> readings = log.view.samples(column_of(axis), log.range, buffer);
    bool quieter = false;
    out.axes.push_back(axis_causes(rest, axis, log, readings, quieter));
    quieter_axes += quieter ? 1 : 0;
    if (!axis.fit->bound) continue;
    std::vector<UpperDensity> upper = axis.fit->bound->upper;
    if (noise::raise_to_motion(upper, readings, log.view.interval_s, *axis.fit, log.moves ? log.vibration_hz : 0, axis.fit->bound->confidence))
      out.upper.emplace(axis.name, std::move(upper));
  }
  if (!rest.from_data_sheet() && 2 * quieter_axes > out.axes.size())
    throw Unsupported(fmt::format("{}: scatters more at rest than {} after --moving; expected the log at rest first: imulab noise {} --moving {}",
                                  rest.recording, recording.name, recording.name, rest.recording));
  if (const std::size_t n = log.view.saturated_in(log.range); n > 0)
    out.warnings.push_back(fmt::format("{}: {} samples are saturated: the factors are too small", recording.name, n));
  return out;
}

}  // namespace imulab
