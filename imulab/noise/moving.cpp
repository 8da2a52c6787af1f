#include "imulab/noise/moving.hpp"

#include "imulab/core/statistics.hpp"
#include "imulab/error.hpp"
#include "imulab/noise/bound.hpp"
#include "imulab/noise/moving_slow.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace imulab {
namespace {

/// Mean of N^2 of a triad; 0 if no axis determines it.
double mean_square_N(const NoiseAnalysis& rest, std::string_view triad) {
  double sum = 0, axes = 0;
  for (const NoiseAxis& axis : rest.axes)
    if (axis.name.starts_with(triad) && axis.fit && axis.fit->N.determined) sum += axis.fit->N.value * axis.fit->N.value, ++axes;
  return axes > 0 ? sum / axes : 0;
}

/// Mean length of the parts that were used, and their number.
std::pair<double, std::size_t> mean_length(const std::vector<PartResidual>& parts) {
  double sum = 0;
  std::size_t used = 0;
  for (const PartResidual& part : parts)
    if (part.used) sum += part.end_s - part.begin_s, ++used;
  return {used > 0 ? sum / static_cast<double>(used) : 0, used};
}

/// True if the first is to be shown in place of the second: a determined factor before one that is not, the larger one of two.
bool outranks(const MovingCause& a, const MovingCause& b) {
  if (a.factor.determined != b.factor.determined) return a.factor.determined;
  return a.factor.determined && a.factor.value > b.factor.value;
}

const MovingCause* determined_cause(const MovingAxis& axis, std::string_view name) {
  for (const MovingCause& cause : axis.causes)
    if (cause.name == name && cause.factor.determined) return &cause;
  return nullptr;
}

MovingTotal total_of(double factor, double at_rest) { return {factor, factor * at_rest}; }

/// Equation (7), and the parameters that the other causes multiply.
void add_totals(MovingAxis& axis, const NoiseAxis& rest) {
  const auto factor = [&](std::string_view name) {
    const MovingCause* const cause = determined_cause(axis, name);
    return cause == nullptr ? NAN : cause->factor.value;
  };
  const auto or_one = [](double f) { return std::isnan(f) ? 1 : f; };
  const NoiseFit& fit = *rest.fit;
  const double white = factor("white"), motion = factor("motion");
  const double spectral = white * std::sqrt(std::pow(or_one(factor("vibration")), 2) + std::pow(or_one(factor("stamps")), 2) - 1);
  axis.N = total_of(std::fmax(spectral, motion), fit.N.value);  // of a number and NaN the number
  axis.slow_N = total_of(factor("below 1 Hz"), fit.N.value);
  axis.K = total_of(factor("drift"), fit.K.determined ? fit.K.value : fit.K.upper);
  if (const MovingCause* const shift = determined_cause(axis, "rectification"))
    axis.bias = {shift->factor.value, shift->factor.value > 1 ? std::abs(shift->size) : 0};
}

}  // namespace

MovingEvidence moving_calibration(const NoiseAnalysis& rest, const Calibration& calibration, const std::string& file) {
  const Quality& quality = calibration.quality;
  const auto [rotation_s, rotations] = mean_length(quality.rotations);
  const auto [rest_s, rests] = mean_length(quality.rests);
  if (!quality.rotation_residual_deg || !(rotation_s > 0) || !(rest_s > 0))
    throw Unsupported(file + ": has no rotations predicted from rest to rest; expected a calibration by the method handheld with ten or more");
  const double gyro = mean_square_N(rest, "gyro."), accel = mean_square_N(rest, "accel.");
  if (gyro == 0) throw Unsupported(fmt::format("{}: its rotations are compared with the gyros, which {} does not contain", file, rest.recording));
  if (rest.axes.front().unit == "count") throw Error(rest.recording + ": is in counts; expected rad/s and m/s^2 to compare a calibration with");
  const double residual = *quality.rotation_residual_deg * unit::deg, expected = 2 * gyro * rotation_s + 4 * accel / (unit::g * unit::g * rest_s);
  const double freedom = 2 * static_cast<double>(rotations), factor = residual / std::sqrt(expected);
  const auto bound = [&](double p) { return factor * std::sqrt(freedom / chi_square_quantile(p, freedom)); };
  MovingEvidence out{.file = fmt::format("{}: calibration, {} rotations of {:.3g} s", file, rotations, rotation_s), .axes = {}};
  for (const NoiseAxis& axis : rest.axes) {
    MovingCause cause{.name = "motion", .parameter = "N", .file = file};
    if (axis.name.starts_with("gyro."))
      cause.factor = {factor, factor / std::sqrt(2 * freedom), bound(0.975), bound(0.025), true}, cause.size = residual;
    else
      cause.reason = "a calibration compares the rotations of the gyros alone";
    if (axis.fit) out.axes.push_back({.name = axis.name, .unit = axis.unit, .causes = {cause}});
  }
  return out;
}

MovingNoise moving_noise(const NoiseAnalysis& rest, const std::vector<MovingEvidence>& evidence) {
  MovingNoise out;
  for (const MovingEvidence& e : evidence) {
    out.files.push_back(e.file);
    for (const MovingAxis& found : e.axes) {
      const auto axis = std::ranges::find(out.axes, found.name, &MovingAxis::name);
      if (axis == out.axes.end()) {
        out.axes.push_back(found);
        continue;
      }
      for (const MovingCause& cause : found.causes) {
        const auto known = std::ranges::find(axis->causes, cause.name, &MovingCause::name);
        if (known == axis->causes.end())
          axis->causes.push_back(cause);
        else if (outranks(cause, *known))
          *known = cause;
      }
    }
  }
  for (MovingAxis& axis : out.axes) add_totals(axis, *std::ranges::find(rest.axes, axis.name, &NoiseAxis::name));
  return out;
}

void raise_bounds(NoiseAnalysis& rest, const std::vector<MovingEvidence>& evidence) {
  for (NoiseAxis& axis : rest.axes) {
    if (!axis.fit || !axis.fit->bound) continue;
    NoiseBound& bound = *axis.fit->bound;
    std::vector<UpperDensity> upper = bound.upper;
    bool raised = false;
    for (const MovingEvidence& e : evidence)
      if (const auto of_log = e.upper.find(axis.name); of_log != e.upper.end()) {
        raised = true;
        for (std::size_t i = 0; i < upper.size(); ++i) upper[i].density = std::max(upper[i].density, of_log->second[i].density);
      }
    if (!raised) continue;
    bound = noise::tightest_bound(std::move(upper), rest.interval_s, {bound.horizon_s, bound.confidence});
    bound.in_motion = true;
    noise::set_coasts(bound, *axis.fit);
  }
}

}  // namespace imulab
