#include "imulab/estimate/noise/noise_analysis.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/parallel.hpp"
#include "imulab/recording/clipping.hpp"
#include "imulab/recording/even_stamps.hpp"
#include "imulab/recording/pieces.hpp"
#include "imulab/recording/rests.hpp"
#include "imulab/recording/short_gaps.hpp"
#include "imulab/recording/slow_motion.hpp"
#include "imulab/recording/validate.hpp"

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <span>
#include <utility>

namespace imulab {

namespace {

constexpr double shortest_still_s = 30;
constexpr std::size_t fewest_samples = 1024;

double seconds(const RecordingView& recording, const Range& range) { return static_cast<double>(range.size()) * recording.interval_s; }

/// How often a channel that varies may stand at its end without being called saturated there.
constexpr double seldom = 0.001;

std::string axis_name(std::size_t column) { return fmt::format("{}.{}", column < accel_columns ? "gyro" : "accel", "xyz"[column % 3]); }

std::string clipped_axes(const RecordingView& recording, const Range& range) {
  std::string names;
  for (std::size_t column = gyro_columns; column < gyro_temperature_columns; ++column) {
    std::size_t clipped = 0;
    for_each_clipped(recording, column, range, [&](std::size_t) { ++clipped; });
    if (static_cast<double>(clipped) > seldom * static_cast<double>(range.size())) names += (names.empty() ? "" : ", ") + axis_name(column);
  }
  return names;
}

[[noreturn]] void too_short(const RecordingView& recording, const std::vector<Range>& rests, const Range& best) {
  const std::string expected = fmt::format("expected at least {:g} s and {} samples at rest", shortest_still_s, fewest_samples);
  const Range all{0, recording.size()};
  const std::string where = std::string(recording.name) + ": ";
  if (seconds(recording, all) < shortest_still_s || all.size() < fewest_samples)
    throw Unsupported(fmt::format("{}has {:.3g} s, {} samples: too short to see noise; {}", where, seconds(recording, all), all.size(), expected));
  const std::size_t saturated = recording.saturated.size();
  if (static_cast<double>(saturated) > seldom * static_cast<double>(all.size())) {
    const std::string axes = clipped_axes(recording, all);
    throw Unsupported(fmt::format("{}{} of {} samples are saturated{}: the noise is cut off there; {} without saturation", where, saturated,
                                  all.size(), axes.empty() ? "" : " (" + axes + ")", expected));
  }
  if (rests.empty()) throw Unsupported(fmt::format("{}moves throughout: no rest was found; {}", where, expected));
  Range longest;
  for (const Range& rest : rests)
    if (rest.size() > longest.size()) longest = rest;
  throw Unsupported(fmt::format("{}the longest of {} rests has {:.3g} s, {:.3g} s of it without gaps and slow motion; {}", where, rests.size(),
                                seconds(recording, longest), seconds(recording, best), expected));
}

/// The interval of all of the analysis: nominal, or that of the even clock of stamps whose usual difference is another. The stamps of each eighth are
/// held against it: jitter of a third of it moves the mean of 128 by 0.4 %; 1 % is half a percent of N.
double one_interval(const RecordingView& recording, const Range& range, bool declared, std::vector<std::string>& notes) {
  constexpr std::size_t parts = 8;
  constexpr double most = 0.01;
  std::array<double, parts> hz;
  std::string rates;
  for (std::size_t part = 0; part < parts; ++part) {
    const std::size_t first = range.begin + part * (range.size() - 1) / parts, last = range.begin + (part + 1) * (range.size() - 1) / parts;
    hz[part] = static_cast<double>(last - first) / (recording.time_s(last) - recording.time_s(first));
    rates += fmt::format("{}{:.4g}", part == 0 ? "" : ", ", hz[part]);
  }
  const auto [least, greatest] = std::minmax_element(hz.begin(), hz.end());
  const double nominal = 1 / recording.interval_s;
  if (*greatest / *least - 1 > most)
    throw Unsupported(fmt::format("{}: the rate changes: {} Hz in the eighths of the rest; expected one rate: cut the log", recording.name, rates));
  if (std::max(*greatest / nominal, nominal / *least) - 1 <= most) return recording.interval_s;
  const std::optional<EvenClock> clock = declared ? std::nullopt : even_clock(recording.time_ns.subspan(range.begin, range.size()));
  if (!clock)
    throw Unsupported(fmt::format("{}: the stamps advance at {:.4g} Hz, but {:.4g} Hz {}; expected the right rate_hz, in a session", recording.name,
                                  hz[0], nominal, declared ? "are declared" : "is their usual difference"));
  notes.push_back(fmt::format("the stamps scatter by {:.2g} ms (RMS) about an even clock of {:.6g} ms, which is used in their place",
                              1e3 * clock->scatter_s, 1e3 * clock->interval_s));
  return clock->interval_s;
}

std::vector<std::string> cut_notes(const RecordingView& recording, const std::vector<Range>& rests, const Range& used) {
  std::vector<std::string> notes;
  notes.push_back(fmt::format("at rest: {:.6g} to {:.6g} s, {} samples; {:.3g} of {:.6g} s were cut",
                              recording.time_s(used.begin) - recording.interval_s, recording.time_s(used.end - 1), used.size(),
                              seconds(recording, {0, recording.size() - used.size()}), seconds(recording, {0, recording.size()})));
  double other = 0, at_rest = 0;
  for (const Range& rest : rests) {
    at_rest += seconds(recording, rest);
    if (rest.end <= used.begin || rest.begin >= used.end) other += seconds(recording, rest);
  }
  const double moving = seconds(recording, {0, recording.size()}) - at_rest;
  if (moving > 0.5 * recording.interval_s) notes.push_back(fmt::format("cut: {:.3g} s of motion or knocks", moving));
  if (other > 0) notes.push_back(fmt::format("cut: {:.3g} s of other rests, which are shorter", other));
  if (const std::size_t gaps = recording.gaps.size(); gaps > 0)
    notes.push_back(fmt::format("gaps in the recording: {}; the part used has none", gaps));
  if (const std::size_t n = recording.saturated.size(); n > 0)
    notes.push_back(fmt::format("saturated samples in the recording: {}; the part used has none", n));
  return notes;
}

struct Extent {
  double least, most;
};

Extent extent_of(const RecordingView& recording, std::size_t column, const Range& range) {
  Extent out{HUGE_VAL, -HUGE_VAL};
  for_each_block(recording, column, range, usual_block, [&](std::span<const double> samples) {
    const auto [least, most] = std::minmax_element(samples.begin(), samples.end());
    out = {std::min(out.least, *least), std::max(out.most, *most)};
  });
  return out;
}

void warn_of_temperature(NoiseAnalysis& analysis, const RecordingView& recording, std::size_t column, const Range& range, const char* triad) {
  if (!recording.has(column)) return;
  const Extent temperature = extent_of(recording, column, range);
  if (temperature.most - temperature.least > 1)
    analysis.warnings.push_back(
        fmt::format("the {} temperature changed by {:.3g} during the rest: R, K and B contain its effect; see --remove-temperature", triad,
                    temperature.most - temperature.least));
}

/// A thermometer's own noise would weaken the slope: means over 10 s, and straight lines between their middles; of a short record its readings.
class SmoothTemperature {
 public:
  SmoothTemperature(const RecordingView& recording, std::size_t column, const Range& range)
      : block_(std::max<std::size_t>(1, static_cast<std::size_t>(10 / recording.interval_s))) {
    const std::size_t blocks = std::max<std::size_t>(1, range.size() / block_);
    if (blocks < 2) {
      block_ = 0;
      std::vector<double> buffer;
      const std::span<const double> samples = recording.samples(column, range, buffer);
      means_.assign(samples.begin(), samples.end());
      return;
    }
    for_each_block(recording, column, {range.begin, range.begin + blocks * block_}, block_, [&](std::span<const double> samples) {
      means_.push_back(std::accumulate(samples.begin(), samples.end(), 0.0) / static_cast<double>(block_));
    });
  }
  double operator()(std::size_t k) const {
    if (block_ == 0) return means_[k];
    const double at = (static_cast<double>(k) + 0.5) / static_cast<double>(block_) - 0.5;  // in blocks' middles; beyond the last two along their line
    const auto b = static_cast<std::size_t>(std::clamp(at, 0.0, static_cast<double>(means_.size() - 2)));
    return means_[b] + (at - static_cast<double>(b)) * (means_[b + 1] - means_[b]);
  }

 private:
  std::size_t block_;  // 0: means_ are the readings
  std::vector<double> means_;
};

/// Takes a parabola of the temperature off the readings; returns the slope per unit of the temperature, at its mean.
double remove_parabola(std::vector<double>& readings, const SmoothTemperature& smooth) {
  const std::size_t n = readings.size();
  double sum = 0, least = HUGE_VAL, most = -HUGE_VAL;
  for (std::size_t k = 0; k < n; ++k) {
    const double T = smooth(k);
    sum += T, least = std::min(least, T), most = std::max(most, T);
  }
  const double center = sum / static_cast<double>(n), half = 0.5 * (most - least), origin = readings[0];
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  const auto row = [&](double T) { return Eigen::Vector3d(1, (T - center) / half, std::pow((T - center) / half, 2)); };
  for (std::size_t k = 0; k < n; ++k) {
    const Eigen::Vector3d at = row(smooth(k));
    normal += at * at.transpose(), right += at * (readings[k] - origin);
  }
  const Eigen::Vector3d fitted = normal.ldlt().solve(right);
  for (std::size_t k = 0; k < n; ++k) readings[k] -= row(smooth(k)).tail<2>().dot(fitted.tail<2>());
  return fitted[1] / half;
}

void expect_temperature(const RecordingView& r, const Range& range, std::size_t column, const char* triad) {
  if (!r.has(column))
    throw Unsupported(fmt::format("{}: has no {} temperature to remove; expected a column declared as {}_temperature", r.name, triad, triad));
  const Extent temperature = extent_of(r, column, range);
  if (!(temperature.most > temperature.least))
    throw Unsupported(fmt::format("{}: the {} temperature does not change: nothing to remove", r.name, triad));
}

void warn_of_fit(NoiseAnalysis& analysis, const NoiseAxis& axis) {
  if (!axis.problem.empty()) analysis.warnings.push_back(fmt::format("{}: {}: no coefficients", axis.name, axis.problem));
  if (!axis.fit) return;
  if (axis.fit->cut)
    analysis.warnings.push_back(fmt::format("{}: the spectrum above {:.3g} Hz is not the model's (a filter of another kind, or rounding): not used",
                                            axis.name, axis.fit->highest_hz));
  for (const NoiseMisfit& m : axis.fit->misfits)
    analysis.warnings.push_back(fmt::format("{}: {:.2f} times the model's power at {:.3g} to {:.3g} Hz: all intervals are widened, and may not hold",
                                            axis.name, m.ratio, m.low_hz, m.high_hz));
}

/// One axis: of a column on disk in the memory of `n` numbers.
void analyze_axis(NoiseAxis& axis, const RecordingView& r, std::size_t column, const Range& range, const NoiseOptions& options, double& slope) {
  axis.name = axis_name(column);
  axis.unit = column < accel_columns ? r.gyro_unit : r.accel_unit;
  std::vector<double> buffer;
  if (r.on_disk != nullptr) buffer.reserve(range.size() + 1);  // for the phase in its place
  std::span<const double> readings = r.samples(column, range, buffer);
  if (std::all_of(readings.begin(), readings.end(), [&](double reading) { return reading == readings[0]; })) {
    axis.problem = "all readings are equal";
    return;
  }
  const double step = resolution_of(readings);
  if (options.remove_temperature) {
    if (buffer.empty()) buffer.assign(readings.begin(), readings.end());
    slope = remove_parabola(buffer, SmoothTemperature(r, column + gyro_temperature_columns, range));
    readings = buffer;
  }
  const std::vector<std::size_t> factors = averaging_factors(readings.size());
  axis.fit = fit_noise(readings, r.interval_s, step);
  axis.deviation = buffer.empty() ? deviation(readings, r.interval_s, factors, options.kind)
                                  : deviation_in_place(std::move(buffer), r.interval_s, factors, options.kind);
}

bool rate_is_declared(const RecordingView& recording, const Session& session) {
  return std::any_of(session.recordings.begin(), session.recordings.end(), [&](const RecordingSource& source) {
    return source.rate_hz && (session.recordings.size() == 1 || source.file == recording.name);
  });
}

}  // namespace

StillRange still_range(const RecordingView& recording, const Session& session, std::size_t filled) {
  StillRange still;
  const std::vector<Range> rests = rests_of(recording, session).ranges;
  bool slow_motion = false;
  for (const Range& rest : rests) {
    const std::vector<Range> parts = between_slow_motion(recording, rest);
    slow_motion = slow_motion || parts != std::vector{rest};
    for (const Range& part : parts)
      if (const Range piece = longest_piece(recording, part); piece.size() > still.range.size()) still.range = piece;
  }
  if (seconds(recording, still.range) < shortest_still_s || still.range.size() < fewest_samples) too_short(recording, rests, still.range);
  still.notes = cut_notes(recording, rests, still.range);
  if (slow_motion) still.notes.push_back("slow motion was cut: the mean over a second changes far more than usual");
  still.interval_s = one_interval(recording, still.range, rate_is_declared(recording, session), still.notes);
  if (filled > 0) still.notes.push_back(fmt::format("{} lost samples were filled in", filled));
  return still;
}

StillPart still_part(Recording recording, const Session& session) {
  validate(recording);
  FilledRecording filled = with_short_gaps_filled(std::move(recording));
  StillRange found = still_range(filled.recording, session, filled.filled);
  filled.recording.interval_s = found.interval_s;
  return {std::move(filled.recording), found.range, std::move(found.notes)};
}

NoiseAnalysis analyze_noise(const StillPart& still, const NoiseOptions& options) {
  return analyze_noise(still.recording, {still.range, still.notes, still.recording.interval_s}, options);
}

NoiseAnalysis analyze_noise(const RecordingView& recording, const StillRange& still, const NoiseOptions& options) {
  RecordingView r = recording;
  r.interval_s = still.interval_s;
  if (options.remove_temperature) {
    expect_temperature(r, still.range, gyro_temperature_columns, "gyro");
    expect_temperature(r, still.range, accel_temperature_columns, "accel");
  }
  NoiseAnalysis analysis;
  analysis.recording = r.name;
  analysis.kind = options.kind;
  analysis.interval_s = r.interval_s;
  analysis.samples = still.range.size();
  analysis.begin_s = r.time_s(still.range.begin) - r.interval_s;
  analysis.end_s = r.time_s(still.range.end - 1);
  analysis.notes = still.notes;
  analysis.axes.resize(6);
  std::array<double, 6> slopes{};
  const auto analyze = [&](std::size_t k) { analyze_axis(analysis.axes[k], r, k, still.range, options, slopes[k]); };
  if (r.on_disk != nullptr)
    for (std::size_t k = 0; k < 6; ++k) analyze(k);
  else
    parallel_for(std::size_t{6}, analyze);
  if (options.remove_temperature)
    for (std::size_t k = 0; k < 6; ++k)
      if (analysis.axes[k].fit)
        analysis.notes.push_back(
            fmt::format("{}: a parabola of the temperature was removed, {:.3g} {} per degree at the mean: it may take some of K and B along",
                        analysis.axes[k].name, slopes[k], analysis.axes[k].unit));
  for (const NoiseAxis& axis : analysis.axes) warn_of_fit(analysis, axis);
  if (options.remove_temperature) return analysis;
  warn_of_temperature(analysis, r, gyro_temperature_columns, still.range, "gyro");
  warn_of_temperature(analysis, r, accel_temperature_columns, still.range, "accelerometer");
  return analysis;
}

}  // namespace imulab
