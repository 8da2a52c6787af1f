#include "imulab/rig/machine_points.hpp"

#include "imulab/error.hpp"
#include "imulab/rig/ideal_recording.hpp"
#include "imulab/rig/rig_errors.hpp"
#include "imulab/rig/thermal_scale.hpp"
#include "imulab/units.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace imulab {

namespace {

constexpr Eigen::Index point_blocks = 10;  // of a point: nine degrees of freedom for the noise of its mean

struct PointMeans {
  double mean;
  double sample_variance;  ///< from differences of neighbors, which slow changes do not reach
  double variance;         ///< about the mean
  double block_variance;   ///< of a block's mean times its length: larger than that of samples where their noise is correlated
};

PointMeans means(std::span<const double> samples) {
  const Eigen::Map<const Eigen::VectorXd> x(samples.data(), std::ssize(samples));
  const Eigen::Index n = x.size(), length = n / point_blocks;
  const double sample_variance = n > 1 ? (x.tail(n - 1) - x.head(n - 1)).squaredNorm() / static_cast<double>(2 * (n - 1)) : 0;
  const double variance = n > 1 ? (x.array() - x.mean()).square().sum() / static_cast<double>(n - 1) : 0;
  if (length == 0) return {x.mean(), sample_variance, variance, sample_variance};
  const Eigen::VectorXd block = x.head(point_blocks * length).reshaped(length, point_blocks).colwise().mean().transpose();
  return {x.mean(), sample_variance, variance, (block.array() - block.mean()).square().sum() / (point_blocks - 1) * static_cast<double>(length)};
}

/// Noise of the six channels, summed over points.
struct NoiseSums {
  Vector6d sample = Vector6d::Zero(), block = Vector6d::Zero();
  double points = 0;
};

/// Change with time of a thermal reading within a point, where it stands out of its noise by five sigma.
std::optional<double> drift_of(std::span<const double> x, double interval_s) {
  const std::size_t half = x.size() / 2;
  if (half < 20) return std::nullopt;  // of fewer the noise is not known well enough
  const PointMeans first = means(x.first(half)), last = means(x.last(half));
  const double change = last.mean - first.mean;
  const double sigma = std::sqrt((first.sample_variance + last.sample_variance) / static_cast<double>(half));
  if (std::abs(change) <= 5 * sigma) return std::nullopt;
  return change / (static_cast<double>(x.size() - half) * interval_s);
}

void expect_equal_units(std::span<const Recording> recordings, const Session& session) {
  for (std::size_t r = 1; r < recordings.size(); ++r) {
    const Recording &a = recordings.front(), &b = recordings[r];
    if (std::abs(b.interval_s / a.interval_s - 1) > 0.02)
      throw Error(fmt::format("{}: {} and {} have different sampling rates; expected one rate in all recordings", session.file, a.name, b.name));
    if (a.accel_unit != b.accel_unit || a.gyro_unit != b.gyro_unit)
      throw Error(fmt::format("{}: {} is in {} and {}, {} in {} and {}; expected one unit in all recordings", session.file, a.name, a.accel_unit,
                              a.gyro_unit, b.name, b.accel_unit, b.gyro_unit));
    for (const auto thermal : {&RecordingSource::accel_temperature, &RecordingSource::gyro_temperature}) {
      const auto &x = session.recordings.front().*thermal, &y = session.recordings[r].*thermal;
      if (x.has_value() != y.has_value() || (x && x->unit != y->unit))
        throw Error(
            fmt::format("{}: {} and {} have different thermal readings; expected the same unit in all recordings", session.file, a.name, b.name));
    }
  }
}

/// The steps of a recording, which its machine must be able to do.
std::vector<Step> machine_steps(const Session& session, const RecordingSource& source) {
  const RigDeclaration* const rig = session.rig_of(source);
  if (!rig || !is_machine(rig->kind))
    throw Error(fmt::format("{}: the recording {} {}; expected a rate table, centrifuge or chamber", session.file, source.file,
                            rig ? fmt::format("is from a rig of kind \"{}\"", to_string(rig->kind)) : "has no rig"));
  std::vector<Step> steps = session.steps_of(source);
  try {
    expect_possible(*rig, steps);
  } catch (const Error& e) {
    throw Error(fmt::format("{}: {}", session.file, e.what()));
  }
  return steps;
}

/// PointMeans and noise of the inertial readings, and of the thermal readings or the set point.
void read_samples(MachinePoint& point, const Recording& recording, const Range& range, NoiseSums& raw, NoiseSums& temperature) {
  for (Eigen::Index channel = 0; channel < 6; ++channel) {
    const auto axis = static_cast<std::size_t>(channel % 3);
    const auto samples = std::span(channel < 3 ? recording.accel[axis] : recording.gyro[axis]).subspan(range.begin, range.size());
    const PointMeans m = means(samples);
    point.raw[channel] = m.mean, point.variance[channel] = m.sample_variance, point.scatter[channel] = m.variance;
    if (point.step.kind == StepKind::hold)  // while it turns, horizontal vectors come and go
      raw.sample[channel] += m.sample_variance, raw.block[channel] += m.block_variance;
    const auto& thermal = channel < 3 ? recording.accel_temperature[axis] : recording.gyro_temperature[axis];
    point.temperature[channel] = point.step.temperature.value_or(std::numeric_limits<double>::quiet_NaN());
    if (thermal.empty()) continue;
    const auto readings = std::span(thermal).subspan(range.begin, range.size());
    const PointMeans t = means(readings);
    point.temperature[channel] = t.mean;
    temperature.sample[channel] += t.sample_variance;
    if (!point.drift) point.drift = drift_of(readings, recording.interval_s);
  }
  temperature.points += 1;
  if (point.step.kind == StepKind::hold) raw.points += 1;
}

/// Why a step gives no point; empty where it does.
std::string obstacle(const MachinePoints& points, const MachinePoint& point, const Recording& recording, const Range& range) {
  if (range.size() < 2) return fmt::format("{} samples in it, left out", range.size());
  const auto overlaps = [&](const MachinePoint& p) {
    return p.recording == point.recording && p.step.start < point.step.end && point.step.start < p.step.end;
  };
  if (std::any_of(points.all.begin(), points.all.end(), overlaps))
    return "overlaps an earlier step in time, left out: its samples are not used twice";
  return recording.saturated_in(range) > 0 ? "saturated, left out" : "";
}

/// Where a triad has no thermal reading in any point, there is none; where some points have one, the others must have it, too.
void find_thermal_ranges(MachinePoints& points, const Session& session) {
  for (std::size_t triad = 0; triad < 2; ++triad) {
    ThermalRange& thermal = points.thermal[triad];
    const auto channels = [&](const Vector6d& v) { return v.segment<3>(static_cast<Eigen::Index>(3 * triad)); };
    const auto unknown =
        std::count_if(points.all.begin(), points.all.end(), [&](const MachinePoint& p) { return !channels(p.temperature).allFinite(); });
    if (unknown == std::ssize(points.all)) continue;
    if (unknown > 0)
      throw Error(fmt::format("{}: {} of {} points have neither a thermal reading of the {} nor a set point; expected one in all points or in none",
                              session.file, unknown, points.all.size(), triad == 0 ? "accelerometers" : "gyros"));
    thermal.known = true;
    const auto& source = triad == 0 ? session.recordings.front().accel_temperature : session.recordings.front().gyro_temperature;
    thermal.unit = source ? source->unit : "degC";
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const MachinePoint& p : points.all)
      low = std::min(low, channels(p.temperature).minCoeff()), high = std::max(high, channels(p.temperature).maxCoeff());
    const double noise = std::sqrt(channels(points.thermal_variance).maxCoeff());
    thermal.excited =
        high - low > std::max(thermal.unit == "raw" ? 0.0 : 1.0, 30 * noise / std::sqrt(static_cast<double>(points.all.front().samples)));
    thermal.low = low - 3 * noise, thermal.high = high + 3 * noise;  // where single readings were
  }
}

/// Where block means of holds scatter more than independent samples explain, theirs is the noise.
void compare_blocks(MachinePoints& points, const NoiseSums& raw) {
  points.correlation.setOnes();
  const double limit = 1 + 3 / std::sqrt(2.0 * (point_blocks - 1) * std::max(raw.points, 1.0)) + 0.1;
  for (Eigen::Index k = 0; k < 6; ++k) {
    const double excess = raw.sample[k] > 0 ? std::sqrt(raw.block[k] / raw.sample[k]) : 1;
    if (excess <= limit) continue;
    points.correlation[k] = excess * excess;
    points.warnings.push_back(
        fmt::format("{} {}: means of {} samples scatter {:.2f} times as much as independent samples would; counted in the uncertainties",
                    k < 3 ? "accel" : "gyro", "xyz"[k % 3], points.all.front().samples / static_cast<std::size_t>(point_blocks), excess));
  }
}

}  // namespace

std::string MachinePoint::name(const Session& session) const {
  std::string what = fmt::format("{} {}", to_string(step.kind), mount_name(mount_of(step)));
  if (step.kind == StepKind::spin) what += fmt::format(" at {:g} deg/s", step.rate / unit::deg);
  if (step.temperature) what += fmt::format(", {:g} degC", *step.temperature);
  return fmt::format("{}, step {} ({})", session.recordings[recording].file, number, what);
}

MachinePoints machine_points(std::span<const Recording> recordings, const Session& session) {
  if (recordings.empty() || recordings.size() != session.recordings.size())
    throw Error(
        fmt::format("{}: got {} recordings; expected one for each of the {} declared", session.file, recordings.size(), session.recordings.size()));
  expect_equal_units(recordings, session);
  MachinePoints points;
  points.interval_s = recordings.front().interval_s;
  NoiseSums raw, temperature;
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    std::size_t number = 0;
    for (const Step& step : machine_steps(session, session.recordings[r])) {
      const Range range = recordings[r].samples_in(step.start, step.end);
      MachinePoint point{r, ++number, session.rig_of(session.recordings[r])->kind, step, range.size(), {}, {}, {}, {}, {}};
      if (const std::string why = obstacle(points, point, recordings[r], range); !why.empty()) {
        points.warnings.push_back(point.name(session) + ": " + why);
        continue;
      }
      read_samples(point, recordings[r], range, raw, temperature);
      points.all.push_back(std::move(point));
    }
  }
  if (points.all.empty()) throw Unsupported(session.file + ": no step has samples; expected steps with their times in the clock of their recording");
  points.thermal_variance = temperature.sample / std::max(temperature.points, 1.0);
  compare_blocks(points, raw);
  find_thermal_ranges(points, session);
  return points;
}

MachinePoints planned_points(const Session& procedure, const Vector6d& variance) {
  if (procedure.recordings.empty()) throw Error(procedure.file + ": no recordings; expected one for each machine");
  MachinePoints points;
  points.interval_s = 1 / procedure.recordings.front().rate_hz.value_or(default_sample_rate);
  points.correlation.setOnes(), points.thermal_variance.setZero();
  for (std::size_t r = 0; r < procedure.recordings.size(); ++r) {
    const RecordingSource& source = procedure.recordings[r];
    double celsius = room_temperature;
    std::size_t number = 0;
    for (const Step& step : machine_steps(procedure, source)) {
      const auto samples = static_cast<std::size_t>(std::floor((step.end - step.start) / points.interval_s * (1 + 1e-12)));
      MachinePoint point{r, ++number, procedure.rig_of(source)->kind, step, samples, {}, variance, variance, {}, {}};
      if (samples < 2) throw Error(fmt::format("{}: {}: {} samples; expected two or more", procedure.file, point.name(procedure), samples));
      const Motion motion = steady_motion(step, procedure.site);
      point.raw << motion.force, motion.rate;
      celsius = step.temperature.value_or(celsius);
      for (const bool accel : {true, false}) {
        const std::optional<ThermalSource>& thermal = accel ? source.accel_temperature : source.gyro_temperature;
        const double unread = step.temperature.value_or(std::numeric_limits<double>::quiet_NaN());
        point.temperature.segment<3>(accel ? 0 : 3).setConstant(thermal ? thermal_scale(*thermal).reading(celsius) : unread);
        if (thermal) points.thermal_variance.segment<3>(accel ? 0 : 3).setConstant(thermal->noise * thermal->noise);
      }
      points.all.push_back(std::move(point));
    }
  }
  if (points.all.empty()) throw Error(procedure.file + ": no steps; expected those of the machines");
  find_thermal_ranges(points, procedure);
  return points;
}

std::string unsettled_points(const MachinePoints& points, const Session& session) {
  constexpr double settled = 0.05 / 60;  // K/s: 9 mK over a record of ten seconds, below what thermal readings agree to
  const ThermalRange& thermal = points.thermal[points.thermometer()];
  const bool raw = thermal.unit == "raw";
  const double kelvin = raw ? thermal.size() / 70 : 1;  // readings in raw count as if their range were 70 K
  std::size_t many = 0;
  std::string first;
  double largest = 0;
  for (const MachinePoint& p : points.all) {
    if (p.machine != RigKind::chamber || !p.drift || std::abs(*p.drift) <= settled * kelvin) continue;
    if (many++ == 0) first = p.name(session);
    largest = std::max(largest, std::abs(*p.drift));
  }
  if (many == 0) return "";
  return fmt::format("{} of the chamber's points had not settled (up to {:.2g} {}/min; the first: {})", many, largest * 60, raw ? "raw" : "K", first);
}

namespace {

/// Mean squared misfit of readings to a mount and a sense of rotation, in units of what uncalibrated sensors miss: a tenth of g and 5 %, 3 deg/s and
/// 5 %.
double misfit(std::span<const MachinePoint> points, std::span<const Motion> measured, const Session& session, const Mount& mount, double sign) {
  double sum = 0;
  for (std::size_t k = 0; k < points.size(); ++k) {
    Step step = points[k].step;
    step.mount = mount;
    step.rate *= sign;
    const Motion expected = steady_motion(step, session.site);
    sum += std::pow((measured[k].force - expected.force).norm() / (0.1 * unit::g + 0.05 * expected.force.norm()), 2) +
           std::pow((measured[k].rate - expected.rate).norm() / (3 * unit::deg + 0.05 * expected.rate.norm()), 2);
  }
  return sum / static_cast<double>(points.size());
}

std::vector<Mount> all_mounts() {
  std::vector<Mount> mounts;
  for (int u = 0; u < 3; ++u)
    for (int o = 0; o < 3; ++o)
      for (const int su : {1, -1})
        for (const int so : {1, -1})
          if (u != o) mounts.push_back({{u, su}, {o, so}});
  return mounts;
}

}  // namespace

void expect_declared_mount(std::span<const MachinePoint> points, std::span<const Motion> measured, const Session& session) {
  constexpr double wrong = 25, right = 4;  // five sigma of what uncalibrated sensors miss, and two
  const MachinePoint& first = points.front();
  const Mount declared = mount_of(first.step);
  Mount best = declared;
  double best_sign = 1, least = misfit(points, measured, session, declared, 1);
  if (least < wrong) return;
  for (const Mount& mount : all_mounts())
    for (const double sign : {1.0, -1.0})
      if (const double m = misfit(points, measured, session, mount, sign); m < 0.999 * least) best = mount, best_sign = sign, least = m;
  if (least > right) return;
  const std::string where = fmt::format("{}: {} steps of {}, the first of them step {}", session.file, points.size(),
                                        session.recordings[first.recording].file, first.number);
  if (best == declared)
    throw Error(where + ": the gyros read the opposite of the declared rate about the axis that points up; expected a sign right-handed about up");
  throw Error(fmt::format("{}: mount {} (up, outward) is declared, but the readings are those of {}{}: was the IMU mounted otherwise?", where,
                          mount_name(declared), mount_name(best), best_sign < 0 ? " turned the other way" : ""));
}

}  // namespace imulab
