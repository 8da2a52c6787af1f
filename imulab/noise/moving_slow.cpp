#include "imulab/noise/moving_slow.hpp"

#include "imulab/noise/spectral_terms.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <utility>

namespace imulab::noise {
namespace {

constexpr double two_sided = 1.96;
constexpr double nearly_vertical = 0.9, same_attitude = 5 * unit::deg;

double known_or_bound(const NoiseCoefficient& c) { return c.determined ? c.value : c.upper; }

double mean_in(const RecordingView& log, std::size_t column, const Range& range) {
  double sum = 0, origin = NAN;
  for_each_block(log, column, range, usual_block, [&](std::span<const double> samples) {
    if (std::isnan(origin)) origin = samples[0];
    for (const double s : samples) sum += s - origin;
  });
  return origin + sum / static_cast<double>(range.size());
}

/// The change of a least-squares line over the range.
double line_change(const RecordingView& log, std::size_t column, const Range& range) {
  const double n = static_cast<double>(range.size()), middle = 0.5 * (n - 1), mean = mean_in(log, column, range);
  double product = 0, k = 0;
  for_each_block(log, column, range, usual_block, [&](std::span<const double> samples) {
    for (const double s : samples) product += (k++ - middle) * (s - mean);
  });
  return 12 * product / (n * n - 1);
}

using Force = std::array<double, 3>;

Force mean_force(const RecordingView& log, const Range& range) {
  return {mean_in(log, accel_columns, range), mean_in(log, accel_columns + 1, range), mean_in(log, accel_columns + 2, range)};
}

double length_of(const Force& f) { return std::hypot(f[0], f[1], f[2]); }

double duration(const RecordingView& log, const Range& range) { return static_cast<double>(range.size()) * log.interval_s; }

MovingCause without_factor(const char* name, const char* parameter, std::string reason) {
  MovingCause out{.name = name, .parameter = parameter};
  out.reason = std::move(reason);
  return out;
}

/// A change, and its variance by the noise at rest: white^2 + flicker B^2 + walk_s K^2.
struct SlowChange {
  double change = 0, white = 0, flicker = 0, walk_s = 0;

  double walk(double size, double B) const { return std::sqrt(std::max(0.0, size * size - white * white - flicker * B * B) / walk_s); }
  double allowed(double B, double K) const { return std::sqrt(white * white + flicker * B * B + walk_s * K * K); }
};

NoiseCoefficient drift_factor(const SlowChange& slow, const NoiseFit& fit) {
  const double size = std::abs(slow.change), B = fit.B.determined ? fit.B.value : 0, K = known_or_bound(fit.K);
  const double margin = two_sided * slow.allowed(known_or_bound(fit.B), K);
  const double least = fit.K.determined ? fit.K.lower : K, most = fit.K.determined ? fit.K.upper : K;
  const bool significant = size > margin;
  return determined_factor({.value = significant ? slow.walk(size, B) / K : 1,
                            .low = significant ? slow.walk(size - margin, B) / most : 1,
                            .high = slow.walk(size + margin, B) / least});
}

/// The mean force at rest; nothing if an accelerometer has no noise, or the file no means.
std::optional<Force> force_at_rest(const NoiseAnalysis& rest) {
  Force force{NAN, NAN, NAN};
  for (const NoiseAxis& axis : rest.axes)
    if (axis.name.starts_with("accel.")) force[static_cast<std::size_t>(axis.name.back() - 'x')] = axis.mean;
  return std::isfinite(length_of(force)) ? std::optional(force) : std::nullopt;
}

struct MeanShift {
  double size = 0, tilt = 0;  ///< tilt: of a horizontal accelerometer, the angle [rad] that shifts it as much
  std::string missing = {};   ///< why there is no shift
};

/// The change of the mean from the log at rest. Of the accelerometers, the nearly vertical one has that of the length of the force.
MeanShift mean_shift(const NoiseAnalysis& rest, const NoiseAxis& axis, const RecordingView& log, std::size_t column, const Range& range) {
  if (std::isnan(axis.mean)) return {.missing = "the noise at rest has no mean readings: give the log itself"};
  MeanShift out{.size = mean_in(log, column, range) - axis.mean};
  const std::optional<Force> before = force_at_rest(rest);
  if (!before || !log.has(accel_columns)) {
    if (column >= accel_columns) out.missing = "the attitude is unknown without three accelerometers";
    return out;
  }
  const Force after = mean_force(log, range), &b = *before;
  const double length = length_of(b), cosine = (b[0] * after[0] + b[1] * after[1] + b[2] * after[2]) / (length * length_of(after));
  if (const double angle = std::acos(std::clamp(cosine, -1.0, 1.0)); angle > same_attitude)
    return {.missing = fmt::format("the attitude differs by {:.2g} deg from that of the log at rest", angle / unit::deg)};
  if (column < accel_columns) return out;
  const double vertical = b[column - accel_columns] / length;
  if (std::abs(vertical) < nearly_vertical)
    out.tilt = std::abs(out.size) / length;
  else
    out.size = std::copysign(1.0, vertical) * (length_of(after) - length);
  return out;
}

}  // namespace

NoiseCoefficient determined_factor(const FactorRange& f) {
  const double low = std::max(1.0, f.low), value = std::max(low, f.value), high = std::max(value, f.high);
  constexpr double smallest_sigma = 1e-6;  // of a factor whose interval is one point
  return {value, std::max(smallest_sigma, (high - low) / (2 * two_sided)), low, high, true};
}

double bias_instability(const NoiseAxis& rest) {
  const double floor = std::sqrt(flicker_floor_squared);
  if (rest.fit->B.determined) return floor * rest.fit->B.value;
  double least = floor * rest.fit->B.upper;
  for (const DeviationPoint& p : rest.deviation) least = std::min(least, p.deviation);
  return least;
}

MovingCause drift_cause(const NoiseAxis& rest, const RecordingView& log, std::size_t column, const SlowParts& parts, double floor) {
  const bool gyro = column < accel_columns;
  const double N2 = floor * rest.fit->N.value * rest.fit->N.value, L = duration(log, parts.first);
  SlowChange slow{.white = std::sqrt(12 * N2 / L), .flicker = 9 / std::numbers::pi, .walk_s = 1.2 * L};
  MovingCause out{.name = "drift", .parameter = "K"};
  const std::size_t thermometer = column + gyro_temperature_columns;
  if (parts.at_rest()) {
    slow.change = line_change(log, column, parts.first);
    if (log.has(thermometer)) out.temperature_change = line_change(log, thermometer, parts.first);
  } else {
    slow.white = std::sqrt(N2 / L + N2 / duration(log, parts.second)), slow.flicker = 2 * flicker_floor_squared;
    slow.walk_s = log.interval_s * 0.5 * static_cast<double>(parts.second.begin + parts.second.end - parts.first.begin - parts.first.end);
    slow.change = mean_in(log, column, parts.second) - mean_in(log, column, parts.first);
    if (!gyro) {
      const Force before = mean_force(log, parts.first), after = mean_force(log, parts.second);
      const double vertical = before[column - accel_columns] / length_of(before);
      if (std::abs(vertical) < nearly_vertical)
        return without_factor("drift", "K", "the log moves, and between its rests only the force along the vertical is known");
      slow.change = std::copysign(1.0, vertical) * (length_of(after) - length_of(before));
    }
    if (log.has(thermometer)) out.temperature_change = mean_in(log, thermometer, parts.second) - mean_in(log, thermometer, parts.first);
  }
  out.size = slow.change, out.factor = drift_factor(slow, *rest.fit);
  if (!rest.fit->K.determined) out.reason = "the log at rest only bounds K: the factor multiplies the bound";
  return out;
}

MovingCause rectification_cause(const NoiseAnalysis& rest, const NoiseAxis& axis, const RecordingView& log, std::size_t column, const Range& range,
                                double floor) {
  const MeanShift shift = mean_shift(rest, axis, log, column, range);
  if (!shift.missing.empty()) return without_factor("rectification", "bias", shift.missing);
  const NoiseFit& fit = *axis.fit;
  const double m = bias_instability(axis), K = fit.K.determined ? fit.K.value : 0, N2 = fit.N.value * fit.N.value;
  const double rest_s = rest.end_s - rest.begin_s, log_s = duration(log, range), between_s = log.time_s(range.begin) - rest.end_s;
  constexpr double one_clock_s = 86400;  // logs of one clock follow each other within a day
  const bool follows = between_s >= 0 && between_s < one_clock_s;
  const double walk_s = rest_s / 3 + log_s / 3 + (follows ? between_s : 0);
  const double u = std::sqrt(N2 / rest_s + floor * N2 / log_s + 2 * m * m + K * K * walk_s);
  const auto factor = [&](double size) { return std::sqrt(1 + std::max(0.0, size * size - u * u) / (m * m)); };
  const double size = std::abs(shift.size), margin = two_sided * u;
  MovingCause out{.name = "rectification", .parameter = "bias"};
  out.size = shift.size;
  if (shift.tilt > 0) {
    out.factor = {NAN, NAN, 0, factor(size + margin), false};
    out.reason = fmt::format("a tilt by {:.2g} deg shifts a horizontal accelerometer as much", shift.tilt / unit::deg);
    return out;
  }
  const bool significant = size > margin;
  out.factor = determined_factor({significant ? factor(size) : 1, significant ? factor(size - margin) : 1, factor(size + margin)});
  if (!follows) out.reason = "includes any change of the bias between the logs";
  return out;
}

}  // namespace imulab::noise
