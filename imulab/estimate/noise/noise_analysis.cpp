#include "imulab/estimate/noise/noise_analysis.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/parallel.hpp"
#include "imulab/recording/clipping.hpp"
#include "imulab/recording/pieces.hpp"
#include "imulab/recording/rests.hpp"
#include "imulab/recording/short_gaps.hpp"

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <span>
#include <utility>

namespace imulab {

namespace {

constexpr double shortest_still_s = 30;
constexpr std::size_t fewest_samples = 1024;

double seconds(const Recording& recording, const Range& range) { return static_cast<double>(range.size()) * recording.interval_s; }

/// How often a channel that varies may stand at its end without being called saturated there.
constexpr double seldom = 0.001;

std::string clipped_axes(const Recording& recording, const Range& range) {
  std::string names;
  const auto look = [&](const Columns3& triad, const char* triad_name) {
    for (std::size_t j = 0; j < 3; ++j) {
      const std::vector<double> readings(triad[j].begin() + static_cast<std::ptrdiff_t>(range.begin),
                                         triad[j].begin() + static_cast<std::ptrdiff_t>(range.end));
      if (static_cast<double>(clipped_samples(readings).size()) > seldom * static_cast<double>(range.size()))
        names += fmt::format("{}{}.{}", names.empty() ? "" : ", ", triad_name, "xyz"[j]);
    }
  };
  look(recording.gyro, "gyro");
  look(recording.accel, "accel");
  return names;
}

[[noreturn]] void too_short(const Recording& recording, const std::vector<Range>& rests, const Range& best) {
  const std::string expected = fmt::format("expected at least {:g} s and {} samples at rest", shortest_still_s, fewest_samples);
  const Range all{0, recording.size()};
  const std::string where = recording.name + ": ";
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
  throw Unsupported(fmt::format("{}the longest of {} rests has {:.3g} s, {:.3g} s of it without gaps; {}", where, rests.size(),
                                seconds(recording, longest), seconds(recording, best), expected));
}

std::vector<std::string> cut_notes(const Recording& recording, const std::vector<Range>& rests, const Range& used) {
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

bool temperature_known(const Columns3& temperature, const Range& range) { return temperature[0].size() >= range.end; }

std::vector<double> part_of(const std::vector<double>& column, const Range& range) {
  return {column.begin() + static_cast<std::ptrdiff_t>(range.begin), column.begin() + static_cast<std::ptrdiff_t>(range.end)};
}

void warn_of_temperature(NoiseAnalysis& analysis, const Columns3& temperature, const Range& range, const char* triad) {
  if (!temperature_known(temperature, range)) return;
  const std::vector<double> part = part_of(temperature[0], range);
  const auto [least, most] = std::minmax_element(part.begin(), part.end());
  if (*most - *least > 1)
    analysis.warnings.push_back(fmt::format(
        "the {} temperature changed by {:.3g} during the rest: R, K and B contain its effect; see --remove-temperature", triad, *most - *least));
}

/// A thermometer's own noise would weaken the slope: means over 10 s, and straight lines between their middles.
std::vector<double> smoothed(const std::vector<double>& temperature, double interval_s) {
  const auto block = std::max<std::size_t>(1, static_cast<std::size_t>(10 / interval_s));
  const std::size_t blocks = std::max<std::size_t>(1, temperature.size() / block);
  if (blocks < 2) return temperature;
  std::vector<double> means(blocks), out(temperature.size());
  for (std::size_t b = 0; b < blocks; ++b) {
    const auto first = temperature.begin() + static_cast<std::ptrdiff_t>(b * block);
    means[b] = std::accumulate(first, first + static_cast<std::ptrdiff_t>(block), 0.0) / static_cast<double>(block);
  }
  for (std::size_t k = 0; k < out.size(); ++k) {
    const double at = (static_cast<double>(k) + 0.5) / static_cast<double>(block) - 0.5;  // in blocks' middles; beyond the last two along their line
    const auto b = static_cast<std::size_t>(std::clamp(at, 0.0, static_cast<double>(blocks - 2)));
    out[k] = means[b] + (at - static_cast<double>(b)) * (means[b + 1] - means[b]);
  }
  return out;
}

/// Readings less a parabola of the temperature; `slope` per unit of the temperature, at its mean.
std::vector<double> without_temperature(const std::vector<double>& readings, const std::vector<double>& temperature, double interval_s,
                                        double& slope) {
  const std::vector<double> smooth = smoothed(temperature, interval_s);
  const double center = std::accumulate(smooth.begin(), smooth.end(), 0.0) / static_cast<double>(smooth.size());
  const auto [least, most] = std::minmax_element(smooth.begin(), smooth.end());
  const double half = 0.5 * (*most - *least);
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  const auto row = [&](double T) { return Eigen::Vector3d(1, (T - center) / half, std::pow((T - center) / half, 2)); };
  for (std::size_t k = 0; k < smooth.size(); ++k)
    normal += row(smooth[k]) * row(smooth[k]).transpose(), right += row(smooth[k]) * (readings[k] - readings[0]);
  const Eigen::Vector3d fitted = normal.ldlt().solve(right);
  slope = fitted[1] / half;
  std::vector<double> out = readings;
  for (std::size_t k = 0; k < out.size(); ++k) out[k] -= row(smooth[k]).tail<2>().dot(fitted.tail<2>());
  return out;
}

void expect_temperature(const Recording& r, const Range& range, const Columns3& temperature, const char* triad) {
  if (!temperature_known(temperature, range))
    throw Unsupported(fmt::format("{}: has no {} temperature to remove; expected a column declared as {}_temperature", r.name, triad, triad));
  const std::vector<double> part = part_of(temperature[0], range);
  const auto [least, most] = std::minmax_element(part.begin(), part.end());
  if (!(*most > *least)) throw Unsupported(fmt::format("{}: the {} temperature does not change: nothing to remove", r.name, triad));
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

}  // namespace

StillPart still_part(const Recording& recording, const Session& session) {
  StillPart still;
  FilledRecording filled = with_short_gaps_filled(recording);
  still.recording = std::move(filled.recording);
  const std::vector<Range> rests = rests_of(still.recording, session).ranges;
  for (const Range& rest : rests)
    if (const Range piece = longest_piece(still.recording, rest); piece.size() > still.range.size()) still.range = piece;
  if (seconds(still.recording, still.range) < shortest_still_s || still.range.size() < fewest_samples) too_short(still.recording, rests, still.range);
  still.notes = cut_notes(still.recording, rests, still.range);
  if (filled.filled > 0) still.notes.push_back(fmt::format("{} lost samples were filled in", filled.filled));
  return still;
}

NoiseAnalysis analyze_noise(const StillPart& still, const NoiseOptions& options) {
  const Recording& r = still.recording;
  if (options.remove_temperature) {
    expect_temperature(r, still.range, r.gyro_temperature, "gyro");
    expect_temperature(r, still.range, r.accel_temperature, "accel");
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
  parallel_for(std::size_t{6}, [&](std::size_t k) {
    NoiseAxis& axis = analysis.axes[k];
    const std::vector<double>& column = k < 3 ? r.gyro[k] : r.accel[k - 3];
    const Columns3& temperature = k < 3 ? r.gyro_temperature : r.accel_temperature;
    std::span<const double> readings = std::span(column).subspan(still.range.begin, still.range.size());
    axis.name = fmt::format("{}.{}", k < 3 ? "gyro" : "accel", "xyz"[k % 3]);
    axis.unit = k < 3 ? r.gyro_unit : r.accel_unit;
    if (std::all_of(readings.begin(), readings.end(), [&](double reading) { return reading == readings[0]; })) {
      axis.problem = "all readings are equal";
      return;
    }
    const double step = resolution_of(readings);
    std::vector<double> without;
    if (options.remove_temperature) {
      readings = without = without_temperature({readings.begin(), readings.end()}, part_of(temperature[k % 3], still.range), r.interval_s, slopes[k]);
    }
    axis.deviation = deviation(readings, r.interval_s, averaging_factors(readings.size()), options.kind);
    axis.fit = fit_noise(readings, r.interval_s, step);
  });
  if (options.remove_temperature)
    for (std::size_t k = 0; k < 6; ++k)
      if (analysis.axes[k].fit)
        analysis.notes.push_back(
            fmt::format("{}: a parabola of the temperature was removed, {:.3g} {} per degree at the mean: it may take some of K and B along",
                        analysis.axes[k].name, slopes[k], analysis.axes[k].unit));
  for (const NoiseAxis& axis : analysis.axes) warn_of_fit(analysis, axis);
  if (options.remove_temperature) return analysis;
  warn_of_temperature(analysis, r.gyro_temperature, still.range, "gyro");
  warn_of_temperature(analysis, r.accel_temperature, still.range, "accelerometer");
  return analysis;
}

}  // namespace imulab
