#include "imulab/inspection/triads.hpp"

#include "imulab/core/statistics.hpp"
#include "imulab/estimate/coarse/coarse.hpp"
#include "imulab/inspection/names.hpp"
#include "imulab/recording.hpp"
#include "imulab/recording/agreement_at_rest.hpp"
#include "imulab/recording/gyro_saturation.hpp"
#include "imulab/recording/resampling.hpp"
#include "imulab/recording/rest_means.hpp"
#include "imulab/recording/rests_of_view.hpp"
#include "imulab/rests.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace imulab::inspection {
namespace {

constexpr double least_turn = 5 * 3.14159265358979 / 180;

enum class Variation { not_finite, constant, varies };

Variation variation_of(const std::vector<double>& values) {
  if (!std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); })) return Variation::not_finite;
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return *low < *high ? Variation::varies : Variation::constant;
}

/// The column, in steps of its noise so that the thresholds for counts hold whatever its unit: its middle step between samples is 100.
std::vector<double> in_steps(const std::vector<double>& values, std::size_t n, double& step) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < std::min<std::size_t>(n, 20'000); ++i)
    if (values[i] != values[i - 1]) steps.push_back(std::abs(values[i] - values[i - 1]));
  step = steps.empty() ? 1 : 0.01 * median(steps);
  std::vector<double> result(n);
  for (std::size_t i = 0; i < n; ++i) result[i] = values[i] / step;
  return result;
}

/// The least difference between two readings in a row.
double least_step(const SignalTable& table, const SignalTriad& triad) {
  double least = HUGE_VAL;
  for (const std::size_t i : triad) {
    const std::vector<double>& values = table.signals[i].values;
    for (std::size_t k = 1; k < std::min<std::size_t>(values.size(), 20'000); ++k)
      if (values[k] != values[k - 1]) least = std::min(least, std::abs(values[k] - values[k - 1]));
  }
  return std::isfinite(least) ? least : 0;
}

/// One step for the three axes: scales between them stay.
Columns3 columns_of(const SignalTable& table, const SignalTriad& triad, std::size_t n, double& step) {
  step = 0;
  for (const std::size_t i : triad) {
    double own = 0;
    in_steps(table.signals[i].values, n, own);
    step = std::max(step, own);
  }
  Columns3 columns;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::vector<double>& values = table.signals[triad[axis]].values;
    columns[axis].resize(n);
    for (std::size_t i = 0; i < n; ++i) columns[axis][i] = values[i] / step;
  }
  return columns;
}

/// A center other than zero that the rests' means lie about on a sphere: that of unsigned counts, or of sensors with a large offset. Readings whose
/// norm is constant while their direction changes lie about zero: rests that hardly differ in direction determine no other center.
std::optional<Vector3d> far_center(const std::vector<RestMeans>& rests) {
  Vector3d center = Vector3d::Zero();
  for (const RestMeans& rest : rests) center += rest.accel / static_cast<double>(rests.size());
  double reach = 0;
  for (const RestMeans& rest : rests) reach = std::max(reach, (rest.accel - center).norm());
  if (rests.size() < 6 || reach == 0) return std::nullopt;
  const auto shorter = [](const RestMeans& a, const RestMeans& b) { return a.accel.norm() < b.accel.norm(); };
  const auto [least, most] = std::minmax_element(rests.begin(), rests.end(), shorter);
  constexpr double along_a_sphere = 0.3;  // of the reach: an uncalibrated sensor's norm changes by a tenth of it
  if (most->accel.norm() - least->accel.norm() < along_a_sphere * reach) return std::nullopt;
  std::vector<Vector3d> readings;
  for (const RestMeans& rest : rests) readings.emplace_back((rest.accel - center) / reach);
  const auto coarse = coarse::coarse_accel(readings, 1);
  if (!coarse) return std::nullopt;
  const Vector3d bias = -coarse->matrix.inverse() * coarse->offset;
  std::vector<double> norms;
  for (const Vector3d& reading : readings) norms.push_back((reading - bias).norm());
  const auto [nearest, farthest] = std::minmax_element(norms.begin(), norms.end());
  constexpr double scales_differ = 0.3;  // of the axes of an uncalibrated sensor, with room; the readings of no accelerometer lie on no sphere
  if (*farthest - *nearest > scales_differ * median(norms)) return std::nullopt;
  return Vector3d(center + reach * bias);
}

/// True if all readings, at rest and in motion, have one length, but for the rounding of their digits (`least` is a step), while their direction
/// changes: an estimate of gravity by a filter, and no accelerometer, whose offsets and motion change it.
bool has_one_length(const Recording& recording, const std::vector<RestMeans>& rests, double least) {
  constexpr double apart = 0.17;  // rad: directions that offsets would show in
  if (rests.size() < 3 || std::none_of(rests.begin(), rests.end(), [&](const RestMeans& rest) {
        return (rest.accel.normalized() - rests.front().accel.normalized()).norm() > apart;
      }))
    return false;
  std::vector<double> norms;
  for (std::size_t i = 0; i < recording.size(); i += 7) norms.push_back(reading_at(recording.accel, i).norm());
  return robust_sigma(norms) < std::max(0.5 * least, 1e-5 * median(norms));  // 1e-5: no sensor's noise is as small in a sample
}

/// True if the accelerometers read the same in both halves of a rest: a log that never rests has quiet parts, too.
bool is_steady(const Recording& recording, const Range& rest) {
  const auto mean = [&](std::size_t begin, std::size_t end) {
    Vector3d sum = Vector3d::Zero();
    for (std::size_t i = begin; i < end; ++i) sum += reading_at(recording.accel, i);
    return Vector3d(sum / static_cast<double>(end - begin));
  };
  const std::size_t quarter = rest.size() / 4;
  if (quarter == 0) return false;
  const Vector3d whole = mean(rest.begin, rest.end);
  double apart = 0, spread = 0;
  for (std::size_t k = 0; k < 4; ++k) apart = std::max(apart, (mean(rest.begin + k * quarter, rest.begin + (k + 1) * quarter) - whole).norm());
  for (std::size_t i = rest.begin; i < rest.end; ++i) spread += (reading_at(recording.accel, i) - whole).squaredNorm();
  spread = std::sqrt(spread / static_cast<double>(rest.size()));
  constexpr double noise_of_gravity = 0.15;  // more is motion, whatever the sensor
  return apart < 0.03 * whole.norm() && spread < noise_of_gravity * whole.norm();
}

/// Calls `each`(i) for every seventh sample between the rests.
template <class Each>
void for_each_in_motion(const Recording& recording, const std::vector<Range>& rests, const Each& each) {
  std::size_t next = 0;
  for (std::size_t i = 0; i < recording.size(); i += 7) {
    while (next < rests.size() && rests[next].end <= i) ++next;
    if (next == rests.size() || i < rests[next].begin) each(i);
  }
}

/// Spread of the norm between the rests, part of its mean.
double norm_spread_in_motion(const Recording& recording, const std::vector<Range>& rests, const Vector3d& center) {
  std::vector<double> norms;
  for_each_in_motion(recording, rests, [&](std::size_t i) { norms.push_back((reading_at(recording.accel, i) - center).norm()); });
  return norms.size() < 10 ? 0 : robust_sigma(norms) / median(norms);
}

/// False where the readings differ from rest to rest about as much as in motion: gyros read the same at every rest, but for their drift.
bool read_alike_at_rest(const Recording& recording, const std::vector<Range>& ranges, const std::vector<RestMeans>& rests) {
  constexpr double about_as_much = 0.5;
  const Vector3d mean = mean_gyro(rests);
  std::vector<double> at_rest;
  double squares = 0, count = 0;
  for (const RestMeans& rest : rests) at_rest.push_back((rest.gyro - mean).norm());
  for_each_in_motion(recording, ranges, [&](std::size_t i) { squares += (reading_at(recording.gyro, i) - mean).squaredNorm(), ++count; });
  return count < 10 || median(at_rest) < about_as_much * std::sqrt(squares / count);
}

/// The three columns in the order of their names' axes, where these are x, y and z of one sensor: some logs have z first.
std::optional<SignalTriad> by_axes(const SignalTable& table, const SignalTriad& triad) {
  std::array<std::optional<std::size_t>, 3> places;
  const std::string sensor = hint_in(table, triad[0]).sensor;
  for (const std::size_t i : triad) {
    const NameHint hint = hint_in(table, i);
    if (hint.axis >= 0 && hint.sensor == sensor) places[static_cast<std::size_t>(hint.axis)] = i;
  }
  if (!places[0] || !places[1] || !places[2]) return std::nullopt;
  return SignalTriad{*places[0], *places[1], *places[2]};
}

/// False where the names of those with an axis are those of several sensors.
bool of_one_sensor(const SignalTable& table, const SignalTriad& triad) {
  std::optional<std::string> sensor;
  for (const std::size_t i : triad)
    if (const NameHint hint = hint_in(table, i); hint.axis >= 0 && std::exchange(sensor, hint.sensor).value_or(hint.sensor) != hint.sensor)
      return false;
  return true;
}

}  // namespace

double TriadEvidence::gyro_scale() const { return gyro_matrix ? std::cbrt(std::abs(gyro_matrix->determinant())) : 0; }

std::vector<SignalTriad> possible_triads(const SignalTable& table, const std::vector<std::size_t>& without) {
  std::vector<SignalTriad> triads;
  const auto add = [&](SignalTriad triad) {
    if (const auto named = by_axes(table, triad)) triad = *named;
    if (std::find(triads.begin(), triads.end(), triad) == triads.end()) triads.push_back(triad);
  };
  std::vector<std::size_t> usable;
  std::map<std::string, std::array<std::optional<std::size_t>, 3>> named;  // by what the names have in common
  for (std::size_t i = 0; i < table.signals.size(); ++i) {
    const NameHint hint = hint_in(table, i);
    const bool taken = std::find(without.begin(), without.end(), i) != without.end();
    const bool clock = hint.role == Role::time && hint.axis < 0;
    if (taken || clock || hint.role == Role::other || hint.role == Role::temperature) continue;
    const Variation variation = variation_of(table.signals[i].values);
    if (variation == Variation::not_finite) continue;
    if (variation == Variation::varies) usable.push_back(i);  // a constant one is a sensor's only if its name says so: at rest, in coarse steps
    if (hint.axis < 0 || (hint.role != Role::gyro && hint.role != Role::accel)) continue;
    auto& place = named[fmt::format("{} {} {}", hint.role == Role::gyro ? "gyro" : "accel", table.signals[i].table, hint.sensor)]
                       [static_cast<std::size_t>(hint.axis)];
    if (!place) place = i;
  }
  for (const auto& [sensor, places] : named)
    if (places[0] && places[1] && places[2]) add({*places[0], *places[1], *places[2]});
  for (const std::size_t stride : {std::size_t{1}, std::size_t{2}})
    for (std::size_t k = 0; k + 2 * stride < usable.size(); ++k) {
      const SignalTriad triad{usable[k], usable[k + stride], usable[k + 2 * stride]};
      const bool even = triad[1] - triad[0] == triad[2] - triad[1];
      const bool together = table.signals[triad[0]].table == table.signals[triad[2]].table && of_one_sensor(table, triad);
      if (together && (even || usable.size() == 6)) add(triad);
    }
  return triads;
}

TriadEvidence evidence_for(const SignalTable& table, const std::vector<std::int64_t>& time_ns, const SignalTriad& gyro, const SignalTriad& accel,
                           const std::vector<double>& possible_scales, std::size_t most) {
  TriadEvidence evidence;
  evidence.gyro = gyro;
  evidence.accel = accel;
  const std::size_t n = std::min(time_ns.size(), most);
  double gyro_step = 1, accel_step = 1;
  Columns3 gyro_columns = columns_of(table, gyro, n, gyro_step), accel_columns = columns_of(table, accel, n, accel_step);
  RecordingOptions options;
  options.name = table.file;
  options.gyro.unit = options.accel.unit = "count";
  const Recording recording = with_short_gaps_filled(make_recording(Nanoseconds{{time_ns.begin(), time_ns.begin() + static_cast<std::ptrdiff_t>(n)}},
                                                                    std::move(gyro_columns), std::move(accel_columns), options))
                                  .recording;
  const RestDetection detection = detect_rests(recording);
  std::vector<Range> steady;  // samples of the recording with its short gaps filled
  for (const Range& rest : detection.rests) {
    if (!is_steady(recording, rest)) continue;
    steady.push_back(rest);
    const auto begin = std::lower_bound(time_ns.begin(), time_ns.end(), recording.time_ns[rest.begin]);
    const auto end = std::upper_bound(time_ns.begin(), time_ns.end(), recording.time_ns[rest.end - 1]);
    evidence.rests.push_back({static_cast<std::size_t>(begin - time_ns.begin()), static_cast<std::size_t>(end - time_ns.begin())});
  }
  evidence.turning = detection.turning;
  const std::vector<RestMeans> rests = summarize_rests(recording, steady);
  if (rests.empty()) return evidence;

  const std::optional<Vector3d> center = far_center(rests);
  evidence.offset_taken_out = center.has_value();
  std::vector<double> norms;
  for (const RestMeans& rest : rests) {
    const Vector3d force = rest.accel - center.value_or(Vector3d::Zero());
    norms.push_back(accel_step * force.norm());
    evidence.up.push_back(force.normalized());
  }
  evidence.norm = median(norms);
  evidence.norm_least = *std::min_element(norms.begin(), norms.end());
  evidence.norm_most = *std::max_element(norms.begin(), norms.end());
  evidence.filtered = !center && has_one_length(recording, rests, least_step(table, accel) / accel_step);
  evidence.norm_in_motion = norm_spread_in_motion(recording, steady, center.value_or(Vector3d::Zero()));
  if (rests.size() < 2 || !(evidence.norm > 0) || !read_alike_at_rest(recording, steady, rests)) return evidence;

  SensorModel model;
  model.accel.matrix = Matrix3d::Identity() * (9.8 * accel_step / evidence.norm);
  model.accel.offset = -model.accel.matrix * center.value_or(Vector3d::Zero());
  const GyroSaturation saturation(recording);
  const auto judge = [&](const Matrix3d& matrix) {
    model.gyro.matrix = matrix;
    model.gyro.offset = -matrix * mean_gyro(rests);
    const std::vector<GravityAtRest> gravity = gravity_at_rests(recording, steady, model, model);
    std::map<double, double> left;  // by the turn's begin: unexplained
    for (const TurnError& turn : turn_errors(recording, gravity, model, model)) left[turn.begin_s] = turn.after;
    double turned = 0, error = 0;
    std::size_t turns = 0;
    for (std::size_t i = 0; i + 1 < gravity.size(); ++i) {
      const double angle = std::atan2(gravity[i].force.cross(gravity[i + 1].force).norm(), gravity[i].force.dot(gravity[i + 1].force));
      if (angle < least_turn) continue;
      const auto found = left.find(gravity[i].end_s);  // a scale far too small sees no turn at all
      if (const Range turn{gravity[i].range.end, gravity[i + 1].range.begin};
          found == left.end() && (recording.gaps_in(turn) > 0 || saturation.in(turn) > 0))
        continue;  // nobody can judge it
      ++turns;
      turned += angle * angle;
      error += std::pow(found == left.end() ? angle : found->second, 2);
    }
    const double count = std::max<double>(1, static_cast<double>(turns));
    if (evidence.gyro_matrix && std::sqrt(error / count) >= evidence.error) return;
    evidence.turns = turns;
    evidence.turned = std::sqrt(turned / count);
    evidence.error = std::sqrt(error / count);
    evidence.gyro_matrix = matrix / gyro_step;
  };
  if (const auto matrix = coarse::coarse_gyro_in_motion(recording, rests, model, Scaling{})) judge(*matrix);
  if (!evidence.explained())  // few turns, or about one or two axes only: one scale, of those that units have
    for (const double scale : possible_scales) judge(Matrix3d::Identity() * (scale * gyro_step));
  return evidence;
}

}  // namespace imulab::inspection
