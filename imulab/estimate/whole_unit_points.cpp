#include "imulab/estimate/whole_unit_points.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/units.hpp"
#include "imulab/rig/machine.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

namespace imulab {

namespace {

constexpr std::size_t blocks = 10;  // of a point: nine degrees of freedom for the noise of its mean

/// Samples whose whole interval lies inside the step.
Range samples_of(const Recording& recording, const Step& step) {
  const auto ns = [](double s) { return static_cast<std::int64_t>(std::llround(1e9 * s)); };
  const std::int64_t slack = ns(0.01 * recording.interval_s);  // jitter of the stamps
  const auto& t = recording.time_ns;
  const auto first = std::lower_bound(t.begin(), t.end(), ns(step.start + recording.interval_s) - slack);
  const auto last = std::upper_bound(first, t.end(), ns(step.end) + slack);
  return {static_cast<std::size_t>(first - t.begin()), static_cast<std::size_t>(last - t.begin())};
}

struct Means {
  double mean = 0;
  double sample_variance = 0;  // from differences of neighbours, which slow changes do not reach
  double block_variance = 0;   // of a block's mean times its length: larger than that of samples where their noise is correlated
};

Means means(std::span<const double> x) {
  Means m;
  for (const double v : x) m.mean += v / static_cast<double>(x.size());
  for (std::size_t k = 1; k < x.size(); ++k) m.sample_variance += (x[k] - x[k - 1]) * (x[k] - x[k - 1]) / 2;
  if (x.size() > 1) m.sample_variance /= static_cast<double>(x.size() - 1);
  const std::size_t length = x.size() / blocks;
  m.block_variance = m.sample_variance;
  if (length == 0) return m;
  std::array<double, blocks> block{};
  double middle = 0;
  for (std::size_t b = 0; b < blocks; ++b) {
    for (std::size_t k = 0; k < length; ++k) block[b] += x[b * length + k] / static_cast<double>(length);
    middle += block[b] / blocks;
  }
  m.block_variance = 0;
  for (const double b : block) m.block_variance += (b - middle) * (b - middle) / (blocks - 1) * static_cast<double>(length);
  return m;
}

/// Sums over points of what the noise is taken from.
struct NoiseSums {
  Vector6d sample = Vector6d::Zero(), block = Vector6d::Zero();
  double points = 0;
  void add(std::size_t channel, const Means& m) {
    sample[static_cast<Eigen::Index>(channel)] += m.sample_variance;
    block[static_cast<Eigen::Index>(channel)] += m.block_variance;
  }
};

/// Change with time of a thermal reading within a point, where it stands out of its noise by five sigma.
std::optional<double> drift_of(std::span<const double> x, double interval_s) {
  const std::size_t half = x.size() / 2;
  if (half < 20) return std::nullopt;  // of fewer the noise is not known well enough
  const Means first = means(x.first(half)), last = means(x.last(half));
  const double change = last.mean - first.mean;
  const double sigma = std::sqrt((first.sample_variance + last.sample_variance) / static_cast<double>(half));
  if (std::abs(change) <= 5 * sigma) return std::nullopt;
  return change / (static_cast<double>(x.size() - half) * interval_s);
}

void check_units(const std::vector<Recording>& recordings, const Session& session) {
  for (std::size_t r = 1; r < recordings.size(); ++r) {
    const Recording &a = recordings.front(), &b = recordings[r];
    if (std::abs(b.interval_s / a.interval_s - 1) > 0.02)
      throw Error(fmt::format("{}: {} and {} have different sampling rates: one rate in all recordings was expected", session.file, a.name, b.name));
    if (a.accel_unit != b.accel_unit || a.gyro_unit != b.gyro_unit)
      throw Error(fmt::format("{}: {} is in {} and {}, {} in {} and {}: one unit in all recordings was expected", session.file, a.name, a.accel_unit,
                              a.gyro_unit, b.name, b.accel_unit, b.gyro_unit));
    for (const auto thermal : {&RecordingSource::accel_temperature, &RecordingSource::gyro_temperature}) {
      const auto &x = session.recordings.front().*thermal, &y = session.recordings[r].*thermal;
      if (x.has_value() != y.has_value() || (x && x->unit != y->unit))
        throw Error(
            fmt::format("{}: {} and {} have different thermal readings: the same unit in all recordings was expected", session.file, a.name, b.name));
    }
  }
}

/// The thermal readings of a point: measured, else its set point.
void set_temperatures(WholeUnitPoint& point, const Recording& recording, const Range& range, NoiseSums& noise) {
  for (std::size_t channel = 0; channel < 6; ++channel) {
    const auto& column = channel < 3 ? recording.accel_temperature[channel] : recording.gyro_temperature[channel - 3];
    double& value = point.temperature[static_cast<Eigen::Index>(channel)];
    if (column.empty()) {
      value = point.step.temperature.value_or(std::numeric_limits<double>::quiet_NaN());
      continue;
    }
    const auto readings = std::span(column).subspan(range.begin, range.size());
    const Means m = means(readings);
    value = m.mean;
    noise.add(channel, m);
    if (!point.drift) point.drift = drift_of(readings, recording.interval_s);
  }
}

bool saturated(const Recording& recording, const Range& range) {
  const auto at = std::lower_bound(recording.saturated.begin(), recording.saturated.end(), range.begin);
  return at != recording.saturated.end() && *at < range.end;
}

/// Where a triad has no thermal reading in any point, there is none; where some points have set points alone, the others are at fault.
void settle_thermal(WholeUnitPoints& all, const Session& session) {
  for (std::size_t triad = 0; triad < 2; ++triad) {
    const auto reading = [&](const WholeUnitPoint& p) { return p.temperature[static_cast<Eigen::Index>(3 * triad)]; };
    const auto known = std::count_if(all.points.begin(), all.points.end(), [&](const auto& p) { return std::isfinite(reading(p)); });
    const char* const name = triad == 0 ? "accelerometers" : "gyros";
    if (known == 0) continue;
    if (known < static_cast<std::ptrdiff_t>(all.points.size()))
      throw Error(
          fmt::format("{}: {} of {} points have neither a thermal reading of the {} nor temperature_degC, the others have: expected in all or none",
                      session.file, all.points.size() - static_cast<std::size_t>(known), all.points.size(), name));
    all.thermal[triad] = true;
    const auto& source = triad == 0 ? session.recordings.front().accel_temperature : session.recordings.front().gyro_temperature;
    all.thermal_unit[triad] = source ? source->unit : "degC";
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const WholeUnitPoint& p : all.points)
      for (Eigen::Index k = 0; k < 3; ++k) {
        low = std::min(low, p.temperature[3 * static_cast<Eigen::Index>(triad) + k]);
        high = std::max(high, p.temperature[3 * static_cast<Eigen::Index>(triad) + k]);
      }
    const double noise = std::sqrt(all.thermal_variance.segment<3>(static_cast<Eigen::Index>(3 * triad)).maxCoeff());
    all.thermal_excited[triad] =
        high - low > std::max(all.thermal_unit[triad] == "raw" ? 0.0 : 1.0, 30 * noise / std::sqrt(static_cast<double>(all.points.front().samples)));
    all.thermal_range_low[triad] = low - 3 * noise, all.thermal_range_high[triad] = high + 3 * noise;  // where single readings were
  }
}

/// Where block means of holds scatter more than independent samples explain, theirs is the noise.
void finish_noise(WholeUnitPoints& all, const NoiseSums& raw, const NoiseSums& temperature) {
  const double n = std::max(raw.points, 1.0);
  all.thermal_variance = temperature.sample / std::max(temperature.points, 1.0);
  all.correlation.setOnes();
  const double limit = 1 + 3 / std::sqrt(2 * (blocks - 1) * n) + 0.1;
  for (Eigen::Index k = 0; k < 6; ++k) {
    const double excess = raw.sample[k] > 0 ? std::sqrt(raw.block[k] / raw.sample[k]) : 1;
    if (excess <= limit) continue;
    all.correlation[k] = excess * excess;
    all.warnings.push_back(
        fmt::format("{} {}: means of {} samples scatter {:.2f} times as much as independent samples would; counted in the uncertainties",
                    k < 3 ? "accel" : "gyro", "xyz"[k % 3], all.points.empty() ? 0 : all.points.front().samples / blocks, excess));
  }
}

}  // namespace

std::string WholeUnitPoint::name(const Session& session) const {
  std::string what = fmt::format("{} {}", to_string(step.kind), mount_name(mount_of(step)));
  if (step.kind == StepKind::spin) what += fmt::format(" at {:g} deg/s", step.rate / unit::deg);
  if (step.temperature) what += fmt::format(", {:g} degC", *step.temperature);
  return fmt::format("{}, step {} ({})", session.recordings[recording].file, number, what);
}

WholeUnitPoints whole_unit_points(const std::vector<Recording>& recordings, const Session& session) {
  if (recordings.empty() || recordings.size() != session.recordings.size())
    throw Error(fmt::format("{}: {} recordings were given, {} are declared: one for each was expected", session.file, recordings.size(),
                            session.recordings.size()));
  check_units(recordings, session);
  WholeUnitPoints all;
  all.interval_s = recordings.front().interval_s;
  NoiseSums raw, temperature;  // raw: of holds
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    const RecordingSource& source = session.recordings[r];
    const RigDeclaration* const rig = rig_of(session, source);
    if (!rig) throw Error(fmt::format("{}: the recording {} has no rig: rate_table, centrifuge or chamber was expected", session.file, source.file));
    if (!is_machine(rig->kind))
      throw Error(fmt::format("{}: {} is from a rig of kind \"{}\": whole-unit calibration uses rate_table, centrifuge and chamber", session.file,
                              source.file, to_string(rig->kind)));
    const std::vector<Step> steps = steps_of(session, source);
    try {
      expect_possible(*rig, steps);
    } catch (const Error& e) {
      throw Error(fmt::format("{}: {}", session.file, e.what()));
    }
    std::size_t number = 0;
    for (const Step& step : steps) {
      ++number;
      WholeUnitPoint point{r, number, step, 0, {}, {}, {}, {}};
      const Range range = samples_of(recordings[r], step);
      point.samples = range.size();
      if (range.size() < 2) {
        all.warnings.push_back(fmt::format("{}: {} samples in it, left out", point.name(session), range.size()));
        continue;
      }
      if (std::any_of(all.points.begin(), all.points.end(),
                      [&](const WholeUnitPoint& p) { return p.recording == r && p.step.start < step.end && step.start < p.step.end; })) {
        all.warnings.push_back(point.name(session) + ": its time is part of a step before it too, used once and not twice");
        continue;
      }
      if (saturated(recordings[r], range)) {
        all.warnings.push_back(point.name(session) + ": saturated, left out");
        continue;
      }
      for (std::size_t channel = 0; channel < 6; ++channel) {
        const auto& column = channel < 3 ? recordings[r].accel[channel] : recordings[r].gyro[channel - 3];
        const Means m = means(std::span(column).subspan(range.begin, range.size()));
        point.raw[static_cast<Eigen::Index>(channel)] = m.mean;
        point.variance[static_cast<Eigen::Index>(channel)] = m.sample_variance;
        if (step.kind == StepKind::hold) raw.add(channel, m);  // while it turns, horizontal vectors come and go
      }
      set_temperatures(point, recordings[r], range, temperature);
      temperature.points += 1;
      if (step.kind == StepKind::hold) raw.points += 1;
      all.points.push_back(std::move(point));
    }
  }
  if (all.points.empty()) throw Unsupported(session.file + ": no step has samples: [[step]] with its times in the recording's clock was expected");
  finish_noise(all, raw, temperature);
  settle_thermal(all, session);
  return all;
}

}  // namespace imulab
