#include "imulab/simulate/simulate_motion.hpp"

#include "imulab/compensate.hpp"
#include "imulab/error.hpp"
#include "imulab/model/sensor_noise.hpp"
#include "imulab/rig/temperature.hpp"
#include "imulab/simulate/effects.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>

namespace imulab {

namespace {

using namespace simulate;

void check(const SensorModel& model, const std::optional<motion::UnitTemperature>& temperature) {
  if (!model.lever_arm.isZero(0)) throw Error("the IMU has lever arms, but the motion is that of a single point; expected none");
  const auto check_thermal = [&](const TriadModel& triad, const char* name, const ThermalSource* source) {
    if (!triad.varies()) return;
    if (source == nullptr) throw Error(fmt::format("the IMU's {} have thermal terms; expected a temperature profile", name));
    const std::string expected = triad.temperature.value_or(ThermalReading{}).unit;
    if (source->unit != expected)
      throw Error(fmt::format("thermal readings of the {} in \"{}\"; expected \"{}\", as in the IMU's thermal terms", name, source->unit, expected));
  };
  check_thermal(model.gyro, "gyros", temperature ? &temperature->gyro : nullptr);
  check_thermal(model.accel, "accelerometers", temperature ? &temperature->accel : nullptr);
}

/// A triad's source with a sensor for each axis.
ThermalSource three_sensors(ThermalSource source) {
  source.columns = {1, 2, 3};
  return source;
}

}  // namespace

Recording simulate_motion(const std::vector<Increment>& ideal, double interval, const Truth& unit, std::uint64_t seed,
                          const std::optional<motion::UnitTemperature>& temperature) {
  if (!(interval > 0 && std::isfinite(interval))) throw Error(fmt::format("the interval is {} s; expected a positive number", interval));
  throw_problems("the unit", problems_of(unit.model));
  check(unit.model, temperature);
  Recording r;
  r.name = "recording.csv";
  r.interval_s = interval;
  r.gyro_unit = unit.model.gyro.raw_unit.empty() ? "rad/s" : unit.model.gyro.raw_unit;  // a drawn unit does not say
  r.accel_unit = unit.model.accel.raw_unit.empty() ? "m/s^2" : unit.model.accel.raw_unit;
  for (std::size_t i = 0; i < ideal.size(); ++i) r.time_ns.push_back(std::llround(1e9 * interval * static_cast<double>(i + 1)));
  for (const Increment& sample : ideal)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      r.gyro[axis].push_back(sample.angle[static_cast<Eigen::Index>(axis)] / interval);
      r.accel[axis].push_back(sample.velocity[static_cast<Eigen::Index>(axis)] / interval);
    }
  std::vector<TemperatureProfile::State> states;  // in the samples' middles: the mean, the profile being linear
  for (std::size_t i = 0; temperature && i < ideal.size(); ++i) {
    const double celsius = temperature->at(interval * (static_cast<double>(i) + 0.5));
    states.push_back({celsius, celsius});
  }
  add_effects(r, unit.effects, unit.gravity, 0, states);
  MotionColumns columns;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    columns.rate[axis] = r.gyro[axis];
    columns.force[axis] = r.accel[axis];
    for (const bool gyro : {true, false}) {
      const std::span<double> column = gyro ? columns.rate[axis] : columns.force[axis];
      const AxisNoise noise(gyro ? unit.gyro_noise : unit.accel_noise, interval, seed,
                            fmt::format("{} {} on a motion", gyro ? "gyro" : "accel", axis));
      if (noise.slow()) noise.add_slow(column);
      noise.add_fast(0, column);
    }
  }
  if (!temperature) {
    decompensate(unit.model, {}, {}, columns);
    return r;
  }
  const std::vector<double> gyro = followed_readings(unit.model.gyro, temperature->gyro, states);
  const std::vector<double> accel = followed_readings(unit.model.accel, temperature->accel, states);
  decompensate(unit.model, {gyro, gyro, gyro}, {accel, accel, accel}, columns);
  const std::array<Range, 1> all{Range{0, ideal.size()}};
  r.gyro_temperature = thermal_readings(three_sensors(temperature->gyro), states, all, seed, "gyro temperature on a motion");
  r.accel_temperature = thermal_readings(three_sensors(temperature->accel), states, all, seed, "accel temperature on a motion");
  return r;
}

}  // namespace imulab
