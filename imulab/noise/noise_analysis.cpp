#include "imulab/noise/noise_analysis.hpp"

#include "imulab/core/parallel.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/error.hpp"
#include "imulab/noise.hpp"
#include "imulab/noise/bound.hpp"
#include "imulab/recording/rest_or_motion.hpp"
#include "imulab/recording/validate.hpp"

#include <Eigen/Cholesky>
#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <span>
#include <utility>

namespace imulab {
namespace {

/// Returns the largest temperature minus the smallest.
double temperature_change(const RecordingView& recording, std::size_t column, const Range& range) {
  double least = HUGE_VAL, most = -HUGE_VAL;
  for_each_block(recording, column, range, usual_block, [&](std::span<const double> samples) {
    const auto [low, high] = std::minmax_element(samples.begin(), samples.end());
    least = std::min(least, *low), most = std::max(most, *high);
  });
  return most - least;
}

void warn_of_temperature(NoiseAnalysis& analysis, const RecordingView& recording, std::size_t column, const Range& range, const char* triad) {
  if (!recording.has(column)) return;
  if (const double change = temperature_change(recording, column, range); change > 1)
    analysis.warnings.push_back(fmt::format(
        "the {} temperature changed by {:.3g} during the rest: R, K and B contain its effect unless its slope is removed", triad, change));
}

/// Smooths the temperature, because thermometer noise would reduce the slope: means over 10 s joined by lines; readings of a short record.
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

/// Subtracts a parabola in the temperature from the readings; returns the slope per unit of temperature at its mean.
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
  if (!(temperature_change(r, column, range) > 0))
    throw Unsupported(fmt::format("{}: the {} temperature does not change: nothing to remove", r.name, triad));
}

void warn_of_fit(NoiseAnalysis& analysis, const NoiseAxis& axis, bool joined) {
  if (!axis.problem.empty()) analysis.warnings.push_back(fmt::format("{}: {}: no coefficients", axis.name, axis.problem));
  if (!axis.fit) return;
  if (axis.fit->cut && !joined)
    analysis.warnings.push_back(fmt::format("{}: the spectrum above {:.3g} Hz is not the model's (a filter of another kind, or rounding): not used",
                                            axis.name, axis.fit->highest_hz));
  if (axis.fit->accepted()) return;
  std::string misfits;
  for (const NoiseMisfit& m : axis.fit->misfits)
    misfits += fmt::format("{}{:.2f} times at {:.3g} to {:.3g} Hz", misfits.empty() ? "" : ", ", m.ratio, m.low_hz, m.high_hz);
  analysis.warnings.push_back(fmt::format("{}: the power is {} the model's: all intervals are widened, and may not hold", axis.name, misfits));
}

/// Analyzes one axis, from a column on disk with the memory of `n` numbers.
void analyze_axis(NoiseAxis& axis, const RecordingView& r, std::size_t column, const Range& range, const NoiseOptions& options, double& slope) {
  axis.name = axis_name(column);
  axis.unit = column < accel_columns ? r.gyro_unit : r.accel_unit;
  std::vector<double> buffer;
  if (r.on_disk != nullptr) buffer.reserve(range.size() + 1);  // allows the phase to replace the readings
  std::span<const double> readings = r.samples(column, range, buffer);
  if (std::all_of(readings.begin(), readings.end(), [&](double reading) { return reading == readings[0]; })) {
    axis.problem = "all readings are equal";
    return;
  }
  axis.mean = readings[0] + std::transform_reduce(readings.begin(), readings.end(), 0.0, std::plus<>(), [&](double r) { return r - readings[0]; }) /
                                static_cast<double>(readings.size());
  const double step = resolution_of(readings);
  if (options.remove_temperature) {
    if (buffer.empty()) buffer.assign(readings.begin(), readings.end());
    slope = remove_parabola(buffer, SmoothTemperature(r, column + gyro_temperature_columns, range));
    readings = buffer;
  }
  const std::vector<std::size_t> factors = averaging_factors(readings.size());
  axis.fit = fit_noise(readings, r.interval_s, {.step = step, .model = options.model, .bound = options.bound});
  axis.deviation = buffer.empty() ? deviation(readings, r.interval_s, factors, options.kind)
                                  : deviation_in_place(std::move(buffer), r.interval_s, factors, options.kind);
}

}  // namespace

NoiseAnalysis analyze_noise(Recording recording, const Session& session, const NoiseOptions& options) {
  const StillPart still = still_part(std::move(recording), session);
  return analyze_noise(still.recording, still, options);
}

NoiseAnalysis analyze_noise(const RecordingView& recording, const StillRange& still, const NoiseOptions& options) {
  expect_inside(still.range, recording.size(), std::string(recording.name) + ": the part at rest");
  if (still.range.size() == 0 || !(still.interval_s > 0))
    throw Error(std::string(recording.name) + ": no samples at rest; expected some, and their interval");
  RecordingView r = recording;
  r.interval_s = still.interval_s;
  if (options.remove_temperature) {
    if (r.has(gyro_columns)) expect_temperature(r, still.range, gyro_temperature_columns, "gyro");
    if (r.has(accel_columns)) expect_temperature(r, still.range, accel_temperature_columns, "accel");
  }
  NoiseAnalysis analysis;
  analysis.recording = r.name;
  analysis.kind = options.kind;
  analysis.interval_s = r.interval_s;
  analysis.samples = still.range.size();
  analysis.begin_s = r.time_s(still.range.begin) - r.interval_s;
  analysis.end_s = r.time_s(still.range.end - 1);
  analysis.notes = still.notes;
  std::vector<std::size_t> columns;
  for (std::size_t column = gyro_columns; column < gyro_temperature_columns; ++column)
    if (r.has(column)) columns.push_back(column);
  analysis.axes.resize(columns.size());
  std::array<double, 6> slopes{};
  const auto analyze = [&](std::size_t k) { analyze_axis(analysis.axes[k], r, columns[k], still.range, options, slopes[k]); };
  if (r.on_disk != nullptr)
    for (std::size_t k = 0; k < columns.size(); ++k) analyze(k);
  else
    parallel_for(columns.size(), analyze);
  if (options.remove_temperature)
    for (std::size_t k = 0; k < columns.size(); ++k)
      if (analysis.axes[k].fit)
        analysis.notes.push_back(
            fmt::format("{}: a parabola of the temperature was removed, {:.3g} {} per degree at the mean: it may take some of K and B along",
                        analysis.axes[k].name, slopes[k], analysis.axes[k].unit));
  if (options.model) analysis.notes.push_back("model as asked: " + to_string(*options.model) + "; its other terms are zero");
  analysis.warnings = doubts_about_rest(r, still.range);
  for (std::size_t k = 0; k < columns.size(); ++k) warn_of_fit(analysis, analysis.axes[k], options.accel_joined && columns[k] >= accel_columns);
  if (options.remove_temperature) return analysis;
  warn_of_temperature(analysis, r, gyro_temperature_columns, still.range, "gyro");
  warn_of_temperature(analysis, r, accel_temperature_columns, still.range, "accelerometer");
  return analysis;
}

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// A bound above the spectra of all logs; empty if one has none.
std::optional<NoiseBound> common_bound(const std::vector<NoiseAnalysis>& logs, std::size_t axis, const NoiseCoefficients& mean) {
  const auto has_bound = [&](const NoiseAnalysis& log) { return log.axes[axis].fit && log.axes[axis].fit->bound; };
  if (!std::ranges::all_of(logs, has_bound)) return {};
  const NoiseBound& first = *logs.front().axes[axis].fit->bound;
  std::vector<UpperDensity> upper = first.upper;
  for (const NoiseAnalysis& log : logs)
    for (UpperDensity& u : upper) u.density = std::max(u.density, noise::at_frequencies(log.axes[axis].fit->bound->upper, {u.hz}).front().density);
  NoiseBound out = noise::tightest_bound(std::move(upper), logs.front().interval_s, {first.horizon_s, first.confidence});
  noise::set_coasts(out, mean);
  return out;
}

/// The spread t^2 for which sum of (value - mean)^2 / (u^2 + t^2) equals its degrees of freedom (Mandel and Paule 1970), and the mean.
struct CommonValue {
  double mean = 0, sigma = 0, spread = 0;
};

CommonValue common_value(const std::vector<NoiseCoefficient>& values) {
  const auto with = [&](double t2) {
    CommonValue out;
    double weights = 0;
    for (const NoiseCoefficient& c : values) {
      const double w = 1 / (c.standard_uncertainty * c.standard_uncertainty + t2);
      out.mean += w * c.value, weights += w;
    }
    out.mean /= weights, out.sigma = 1 / std::sqrt(weights), out.spread = std::sqrt(t2);
    return out;
  };
  const double freedom = static_cast<double>(values.size()) - 1;
  const auto scatter = [&](double t2) {
    const double mean = with(t2).mean;
    double sum = 0;
    for (const NoiseCoefficient& c : values) sum += std::pow(c.value - mean, 2) / (c.standard_uncertainty * c.standard_uncertainty + t2);
    return sum - freedom;
  };
  if (values.size() < 2 || scatter(0) <= 0) return with(0);
  double low = 0, high = 1e-300;
  for (const NoiseCoefficient& c : values) high = std::max(high, 4 * c.value * c.value);
  while (scatter(high) > 0) high *= 4;
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (low + high);
    (scatter(middle) > 0 ? low : high) = middle;
  }
  return with(high);
}

BatchCoefficient together(const std::vector<NoiseCoefficient>& logs) {
  BatchCoefficient out;
  std::vector<NoiseCoefficient> known;
  for (std::size_t i = 0; i < logs.size(); ++i) {
    if (logs[i].determined) known.push_back(logs[i]);
    const double size = std::abs(logs[i].determined ? logs[i].value : logs[i].upper);
    if (i == 0 || size > out.worst) out.worst = size, out.worst_log = i;
  }
  out.determined = static_cast<int>(known.size());
  out.spread = nan;
  if (known.empty()) {
    out.mean = undetermined_below(out.worst);
    return out;
  }
  const CommonValue all = common_value(known);
  if (known.size() > 1) out.spread = all.spread;
  // The spread of few logs is uncertain, so Student's quantile is used if there is a spread.
  const double width = known.size() > 1 && all.spread > 0 ? student_quantile(0.975, static_cast<double>(known.size()) - 1) : 1.96;
  out.mean = {all.mean, all.sigma, all.mean - width * all.sigma, all.mean + width * all.sigma, true};
  return out;
}

}  // namespace

NoiseBatch noise_batch(std::vector<NoiseAnalysis> logs) {
  if (logs.empty()) throw Error("no logs; expected one or more");
  NoiseBatch batch{std::move(logs), {}};
  for (const NoiseAnalysis& log : batch.logs)
    if (log.axes.size() != batch.logs.front().axes.size() || (!log.axes.empty() && log.axes[0].name != batch.logs.front().axes[0].name))
      throw Error(fmt::format("{}: has other triads than {}; expected logs with the same ones", log.recording, batch.logs.front().recording));
  for (std::size_t k = 0; k < batch.logs.front().axes.size(); ++k) {
    BatchAxis axis{batch.logs.front().axes[k].name, batch.logs.front().axes[k].unit, {}};
    std::array<std::vector<NoiseCoefficient>, 5> values;
    for (const NoiseAnalysis& log : batch.logs) {
      if (log.axes[k].unit != axis.unit)
        throw Error(fmt::format("{}: {} is in {}, that of {} in {}; expected logs in the same unit", log.recording, axis.name, log.axes[k].unit,
                                batch.logs.front().recording, axis.unit));
      if (const auto& fit = log.axes[k].fit)
        for (std::size_t j = 0; j < 5; ++j) values[j].push_back(*std::array{&fit->Q, &fit->N, &fit->B, &fit->K, &fit->R}[j]);
    }
    if (values[0].empty()) continue;
    for (std::size_t j = 0; j < 5; ++j) axis.coefficients[j] = together(values[j]);
    const auto mean = [&](std::size_t j) { return axis.coefficients[j].mean; };
    axis.bound = common_bound(batch.logs, k, {.Q = mean(0), .N = mean(1), .B = mean(2), .K = mean(3), .R = mean(4)});
    batch.axes.push_back(std::move(axis));
  }
  return batch;
}

}  // namespace imulab
