#include "imulab/rig/temperature.hpp"

#include "imulab/core/random.hpp"
#include "imulab/error.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace imulab {

TemperatureProfile::TemperatureProfile(const RigMotion& motion, const RigDeclaration* rig) {
  double ramp = 0;
  if (rig != nullptr && rig->kind == RigKind::chamber) time_constant_ = rig->time_constant, hysteresis_ = rig->hysteresis, ramp = rig->ramp;
  double target = motion.pieces.front().temperature.value_or(room_temperature), air = target;
  State now{air, air};
  if (rig == nullptr || rig->kind == RigKind::none) {
    for (std::size_t first = 0, next = 0; first < motion.pieces.size(); first = next) {
      for (next = first; next < motion.pieces.size() && motion.pieces[next].temperature == motion.pieces[first].temperature;) ++next;
      const double begin = motion.pieces[first].begin, end = motion.pieces[next - 1].end;
      target = motion.pieces[first].temperature.value_or(target);
      append(begin, end, air, (target - air) / (end - begin), now);
      air = target;
    }
    return;
  }
  for (const MotionPiece& piece : motion.pieces) {
    target = piece.temperature.value_or(target);
    if (ramp == 0) air = target;
    const double slope = std::copysign(ramp, target - air), arrival = air == target ? piece.begin : piece.begin + (target - air) / slope;
    if (arrival > piece.begin) append(piece.begin, std::min(arrival, piece.end), air, slope, now);
    air = arrival <= piece.end ? target : air + slope * (piece.end - piece.begin);
    if (arrival < piece.end) append(arrival, piece.end, air, 0, now);
  }
}

void TemperatureProfile::append(double begin, double end, double air, double slope, State& now) {
  segments_.push_back({begin, air, slope, now});
  // T has its extreme where the air has caught up with it: T' = s - (T0 - A0 + s tau) / tau e^(-t / tau) = 0.
  const double lag = slope * time_constant_, off = now.unit - air + lag;
  const double turn = lag != 0 && off / lag > 1 ? begin + time_constant_ * std::log(off / lag) : end;
  if (turn < end) {
    const State there = in(segments_.back(), turn);
    segments_.push_back({turn, air + slope * (turn - begin), slope, there});
  }
  now = in(segments_.back(), end);
}

TemperatureProfile::State TemperatureProfile::in(const Segment& s, double t) const {
  const double lasting = t - s.begin, air = s.air + s.slope * lasting;
  double unit = air;
  if (time_constant_ > 0) {
    const double lag = s.slope * time_constant_;
    unit = air - lag + (s.at_begin.unit - s.air + lag) * std::exp(-lasting / time_constant_);
  }
  return {unit, std::clamp(s.at_begin.zeros, unit - hysteresis_, unit + hysteresis_)};  // T is monotone here
}

TemperatureProfile::State TemperatureProfile::at(double t) const {
  const auto after = std::upper_bound(segments_.begin(), segments_.end(), t, [](double x, const Segment& s) { return x < s.begin; });
  return in(after == segments_.begin() ? *after : *(after - 1), t);
}

std::vector<TemperatureProfile::State> temperatures_at(std::span<const Range> samples, const TemperatureProfile& profile, double interval_s) {
  std::vector<TemperatureProfile::State> out;
  for (const Range& range : samples)
    for (std::size_t i = range.begin; i < range.end; ++i) out.push_back(profile.at((static_cast<double>(i) + 0.5) * interval_s));
  return out;
}

Columns3 thermal_readings(const std::optional<ThermalSource>& source, std::span<const TemperatureProfile::State> temperatures,
                          std::span<const Range> samples, std::uint64_t seed, const std::string& purpose) {
  Columns3 readings;
  if (!source) return readings;
  const ThermalScale scale = thermal_scale(*source);
  const std::size_t sensors = source->columns.size() == 3 ? 3 : 1;
  for (std::size_t s = 0; s < sensors; ++s) {
    std::vector<double>& column = readings[s];
    for (const TemperatureProfile::State& state : temperatures) column.push_back(scale.reading(state.unit));
    if (source->noise == 0) continue;
    const RandomStream draws(seed, fmt::format("noise {} of {}", s, purpose));
    std::vector<double> noise;
    std::size_t place = 0;
    for (const Range& range : samples) {
      noise.resize(range.size());
      draws.normals(range.begin, noise);
      for (const double x : noise) column[place++] += source->noise * x;
    }
  }
  if (sensors == 1) readings[1] = readings[2] = readings[0];
  return readings;
}

std::vector<double> followed_readings(const TriadModel& model, const std::optional<ThermalSource>& source,
                                      std::span<const TemperatureProfile::State> temperatures) {
  std::vector<double> out;
  if (!model.temperature) return out;
  const std::string& unit = model.temperature->unit;
  const bool as_read = source && source->unit == unit;
  if (!as_read && unit == "raw") throw Error("the IMU to simulate has its reference temperature in \"raw\"; expected a thermal reading in \"raw\"");
  const ThermalScale scale = as_read ? thermal_scale(*source) : thermal_scale(unit);
  for (const TemperatureProfile::State& state : temperatures) out.push_back(scale.reading(state.zeros));
  return out;
}

TriadModel with_readings(TriadModel model, const ThermalScale& from, const ThermalScale& to, const std::string& unit) {
  const double ratio = to.per_K / from.per_K;  // tau in the new readings is ratio times the old
  const auto converted = [&](double reading) { return to.at_25_degC + ratio * (reading - from.at_25_degC); };
  for (int order = 1; order <= 3; ++order) model.thermal.col(order) /= std::pow(ratio, order);
  model.matrix_thermal1 /= ratio, model.matrix_thermal2 /= ratio * ratio;
  if (!model.temperature) return model;
  ThermalReading& t = *model.temperature;
  t.unit = unit, t.reference = converted(t.reference);
  const auto [low, high] = std::minmax({converted(t.range[0]), converted(t.range[1])});
  t.range = {low, high};
  return model;
}

}  // namespace imulab
