#include "imulab/simulate/simulate_motion.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/random.hpp"
#include "imulab/model/compensate.hpp"
#include "imulab/simulate/sensor_noise.hpp"

#include <fmt/format.h>

#include <cmath>

namespace imulab {

namespace {

void check(const SensorModel& model, const std::optional<UnitTemperature>& temperature) {
  if (!model.lever_arm.isZero(0)) throw Error("the unit has lever arms: a motion gives what one point feels, expected none");
  const auto check_thermal = [&](const TriadModel& triad, const char* name, const ThermalSource* source) {
    if (triad.thermal.isZero(0)) return;
    if (source == nullptr) throw Error(fmt::format("the unit's {} have thermal terms: the temperature on the way was expected", name));
    const std::string expected = triad.temperature.value_or(ThermalReading{}).unit;
    if (source->unit != expected)
      throw Error(fmt::format("thermal readings of the {} in \"{}\": \"{}\" was expected, which the unit's thermal terms are in", name, source->unit, expected));
  };
  check_thermal(model.gyro, "gyros", temperature ? &temperature->gyro : nullptr);
  check_thermal(model.accel, "accelerometers", temperature ? &temperature->accel : nullptr);
}

/// Thermal readings without noise: the mean of a sample, the course being straight.
std::vector<double> readings(const TemperatureCourse& course, const ThermalSource& source, std::size_t count, double interval) {
  std::vector<double> out(count);
  for (std::size_t i = 0; i < count; ++i) out[i] = thermal_reading(source, course.at(interval * (static_cast<double>(i) + 0.5)));
  return out;
}

Columns3 with_noise(const std::vector<double>& exact, double sigma, std::uint64_t seed, const char* triad) {
  Columns3 out;
  out.fill(exact);
  if (sigma == 0) return out;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const RandomStream draws(seed, fmt::format("{} {} temperature on a motion", triad, axis));
    for (std::size_t i = 0; i < exact.size(); ++i) out[axis][i] += sigma * draws.normal(i);
  }
  return out;
}

}  // namespace

Recording simulate_motion(const std::vector<Increment>& ideal, double interval, const Truth& unit, std::uint64_t seed,
                          const std::optional<UnitTemperature>& temperature) {
  check(unit.model, temperature);
  Recording r;
  r.name = "recording.csv";
  r.interval_s = interval;
  r.gyro_unit = unit.model.gyro.raw_unit.empty() ? "rad/s" : unit.model.gyro.raw_unit;  // a drawn unit does not say
  r.accel_unit = unit.model.accel.raw_unit.empty() ? "m/s^2" : unit.model.accel.raw_unit;
  for (std::size_t i = 0; i < ideal.size(); ++i) r.time_ns.push_back(std::llround(1e9 * interval * static_cast<double>(i + 1)));
  MotionColumns columns;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto row = static_cast<Eigen::Index>(axis);
    for (const Increment& sample : ideal) {
      r.gyro[axis].push_back(sample.angle[row] / interval);
      r.accel[axis].push_back(sample.velocity[row] / interval);
    }
    columns.rate[axis] = r.gyro[axis];
    columns.force[axis] = r.accel[axis];
    for (const bool gyro : {true, false}) {
      const std::span<double> column = gyro ? columns.rate[axis] : columns.force[axis];
      const AxisNoise noise(gyro ? unit.gyro_noise : unit.accel_noise, interval, seed, fmt::format("{} {} on a motion", gyro ? "gyro" : "accel", axis));
      if (noise.slow()) noise.add_slow(column);
      noise.add_fast(0, column);
    }
  }
  if (!temperature) {
    decompensate(unit.model, {}, {}, columns);
    return r;
  }
  const std::vector<double> gyro = readings(temperature->course, temperature->gyro, ideal.size(), interval);
  const std::vector<double> accel = readings(temperature->course, temperature->accel, ideal.size(), interval);
  decompensate(unit.model, {accel, accel, accel}, {gyro, gyro, gyro}, columns);
  r.gyro_temperature = with_noise(gyro, temperature->gyro.noise, seed, "gyro");
  r.accel_temperature = with_noise(accel, temperature->accel.noise, seed, "accel");
  return r;
}

}  // namespace imulab
