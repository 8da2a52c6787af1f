#include "imulab/recording/agreement_at_rest.hpp"

#include "imulab/core/decomposition.hpp"
#include "imulab/core/rotation.hpp"
#include "imulab/earth.hpp"
#include "imulab/recording/gyro_saturation.hpp"
#include "imulab/recording/overview.hpp"
#include "imulab/units.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

namespace imulab {

namespace {

TriadModel uncalibrated(const TriadModel& m) {
  TriadModel plain;
  plain.raw_unit = m.raw_unit;
  if (m.raw_unit != "count") return plain;
  const double scale = m.matrix.diagonal().mean();
  plain.matrix *= scale;
  const auto inverse = regular_inverse(m.matrix);
  plain.offset = inverse ? Vector3d(scale * *inverse * m.offset) : m.offset;  // zero at the same readings
  return plain;
}

Vector3d mean_of(const Columns3& columns) {
  Vector3d mean = Vector3d::Zero();
  for (std::size_t axis = 0; axis < 3; ++axis)
    mean[static_cast<Eigen::Index>(axis)] =
        std::accumulate(columns[axis].begin(), columns[axis].end(), 0.0) / static_cast<double>(std::max<std::size_t>(1, columns[axis].size()));
  return mean;
}

Vector3d mean_temperature(const Columns3& columns, const Range& range) {
  Columns3 part;
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (!columns[axis].empty())
      part[axis].assign(columns[axis].begin() + static_cast<std::ptrdiff_t>(range.begin),
                        columns[axis].begin() + static_cast<std::ptrdiff_t>(range.end));
  return mean_of(part);
}

/// The middle of a long rest says as much as all of it.
Range shortened(const Range& range) {
  constexpr std::size_t most = 100'000;
  if (range.size() <= most) return range;
  const std::size_t begin = range.begin + (range.size() - most) / 2;
  return {begin, begin + most};
}

double angle_between(const Vector3d& a, const Vector3d& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

/// C_b1,b2: from the axes after the samples of `range` to those before it, against the Earth, which turns by `earth` in the axes before.
Matrix3d rotation_over(const SensorModel& model, const Recording& recording, const Range& range, const Vector3d& earth) {
  const MotionSamples motion = compensated_samples(model, recording, range);
  Matrix3d turned = Matrix3d::Identity();
  for (std::size_t k = 0; k < range.size(); ++k) {
    const double dt = recording.interval(range.begin + k, recording.gyro_increment);
    const Vector3d rate(motion.rate[0][k], motion.rate[1][k], motion.rate[2][k]);
    turned *= rotation_exp(dt * (rate - turned.transpose() * earth));
  }
  return turned;
}

/// The Earth's rate as the gyros measure it in a rest; zero where their offset or noise is larger than it.
Vector3d measured_earth_rate(const SensorModel& model, const Recording& recording, const Range& rest) {
  const Vector3d mean = mean_of(compensated_samples(model, recording, shortened(rest)).rate);
  return mean.norm() < 2 * earth_rate ? mean : Vector3d::Zero();
}

}  // namespace

SensorModel uncalibrated(const SensorModel& model) {
  SensorModel plain;
  plain.accel = uncalibrated(model.accel);
  plain.gyro = uncalibrated(model.gyro);
  return plain;
}

std::vector<GravityAtRest> gravity_at_rests(const Recording& recording, const std::vector<Range>& rests, const SensorModel& before,
                                            const SensorModel& after) {
  std::vector<GravityAtRest> out;
  for (const Range& range : rests) {
    if (range.size() == 0) continue;
    const Range part = shortened(range);
    const Vector3d force = mean_of(compensated_samples(after, recording, part).force);
    out.push_back({range, recording.time_s(range.begin), recording.time_s(range.end - 1), force,
                   mean_of(compensated_samples(before, recording, part).force).norm(), force.norm()});
  }
  return out;
}

std::vector<RestOverTemperature> rests_over_temperature(const Recording& recording, const std::vector<GravityAtRest>& rests, const SensorModel& model,
                                                        const std::array<double, 2>& known_up) {
  SensorModel at_reference = model;
  at_reference.accel.remove_temperature(), at_reference.gyro.remove_temperature();
  std::vector<RestOverTemperature> out;
  std::vector<std::array<Vector3d, 2>> means;  // force, rate
  for (const GravityAtRest& rest : rests) {
    const Range range = shortened(rest.range);
    const MotionSamples with = compensated_samples(model, recording, range), without = compensated_samples(at_reference, recording, range);
    means.push_back({mean_of(with.force), mean_of(with.rate)});
    out.push_back({{mean_temperature(recording.accel_temperature, range), {}, means.back()[0].norm(), mean_of(without.force).norm()},
                   {mean_temperature(recording.gyro_temperature, range), {}, means.back()[1].norm(), mean_of(without.rate).norm()}});
  }
  for (std::size_t begin = 0, end = 0; begin < out.size(); begin = end) {
    constexpr double alike = 0.02;  // directions: a degree
    std::array<Vector3d, 2> mean = means[begin];
    for (end = begin + 1; end < out.size() && rests[end].range.begin <= rests[end - 1].range.end + 1 &&
                          (means[end][0] - means[end - 1][0]).norm() < alike * means[end][0].norm();
         ++end)
      mean[0] += means[end][0], mean[1] += means[end][1];
    const Vector3d up = mean[0].normalized();
    for (std::size_t k = begin; k < end; ++k)
      for (std::size_t triad = 0; triad < 2; ++triad)
        for (Eigen::Index axis = 0; axis < 3; ++axis)
          (triad == 0 ? out[k].accel : out[k].gyro).error[axis] =
              std::isfinite(known_up[triad]) && std::abs(up[axis]) > std::numbers::sqrt2 / 2 ? (means[k][triad].dot(up) - known_up[triad]) / up[axis]
              : end - begin > 1 ? means[k][triad][axis] - mean[triad][axis] / static_cast<double>(end - begin)
                                : std::numeric_limits<double>::quiet_NaN();
  }
  return out;
}

std::vector<TurnError> turn_errors(const Recording& recording, const std::vector<GravityAtRest>& rests, const SensorModel& before,
                                   const SensorModel& after) {
  std::vector<TurnError> out;
  const GyroSaturation saturation(recording);
  for (std::size_t i = 0; i + 1 < rests.size(); ++i) {
    const GravityAtRest &from = rests[i], &to = rests[i + 1];
    if (to.range.begin < from.range.end) continue;
    const Range turn{from.range.end, to.range.begin};
    if (recording.gaps_in(turn) > 0 || saturation.in(turn) > 0) continue;
    const Vector3d earth = measured_earth_rate(after, recording, from.range);
    const auto error = [&](const Matrix3d& turned) { return angle_between(turned.transpose() * from.force, to.force); };
    const Matrix3d turned = rotation_over(after, recording, turn, earth);
    const double angle = rotation_log(turned).norm();
    if (angle < unit::deg) continue;
    out.push_back({from.end_s, to.begin_s, angle, error(&before == &after ? turned : rotation_over(before, recording, turn, earth)), error(turned)});
  }
  return out;
}

}  // namespace imulab
