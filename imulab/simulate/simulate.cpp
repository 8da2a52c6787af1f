#include "imulab/simulate/simulate.hpp"

#include "imulab/core/error.hpp"
#include "imulab/earth/earth.hpp"
#include "imulab/simulate/mean_motion.hpp"
#include "imulab/simulate/sensor_noise.hpp"

#include <fmt/core.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>

namespace imulab {

namespace {

constexpr std::size_t block_size = 1024;  // samples one task computes: six columns of motion stay in the cache
constexpr double default_rate = 100;      // Hz
const std::set<std::string, std::less<>> si_units{"rad/s", "rad", "m/s^2", "m/s"};

MotionColumns columns(Recording& recording, std::size_t begin, std::size_t count) {
  MotionColumns out;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    out.rate[axis] = std::span(recording.gyro[axis]).subspan(begin, count);
    out.force[axis] = std::span(recording.accel[axis]).subspan(begin, count);
  }
  return out;
}

/// The thermal reading of each sample where the model or the recording has one: its step's set point; before the first set point the model's
/// reference.
std::vector<double> temperatures(const RigMotion& motion, const TriadModel& model, std::size_t count, double interval_s) {
  std::vector<double> out(count);
  double now = model.temperature.value_or(ThermalReading{}).reference;
  std::size_t sample = 0;
  for (const MotionPiece& piece : motion.pieces) {
    now = piece.temperature.value_or(now);
    for (; sample < count && (static_cast<double>(sample) + 0.5) * interval_s < piece.end; ++sample) out[sample] = now;
  }
  return out;
}

void validate(const Session& procedure, const RecordingSource& source, const SensorModel& model) {
  if (!procedure.site.latitude) throw Error("[site]: latitude_deg was expected: Earth's rate depends on it");
  if (source.rate_hz && !(*source.rate_hz > 0)) throw Error("[[recording]]: rate_hz above 0 was expected");
  for (const auto& reading : {source.gyro_temperature, source.accel_temperature})
    if (reading && reading->unit != "degC")
      throw Error(
          fmt::format("[[recording]]: a thermal reading in \"{}\": \"degC\", the unit of the steps' set points, was expected", reading->unit));
  for (const auto& reading : {model.gyro.temperature, model.accel.temperature})
    if (reading && reading->unit != "degC")
      throw Error(fmt::format("the unit to simulate has its reference temperature in \"{}\": \"degC\" was expected", reading->unit));
}

/// Nothing but what is known beforehand: names, units, sizes, stamps.
Recording empty_recording(const RecordingSource& source, double rate, std::size_t count) {
  Recording r;
  r.name = source.file;
  r.interval_s = 1 / rate;
  r.gyro_increment = source.gyro.output == Output::increment;
  r.accel_increment = source.accel.output == Output::increment;
  r.gyro_unit = source.gyro.unit == "count" ? "count" : "rad/s";
  r.accel_unit = source.accel.unit == "count" ? "count" : "m/s^2";
  for (auto* triad : {&r.gyro, &r.accel})
    for (auto& column : *triad) column.resize(count);
  r.time_ns.resize(count);
  for (std::size_t i = 0; i < count; ++i) r.time_ns[i] = std::llround(1e9 * static_cast<double>(i + 1) / rate);
  return r;
}

/// What readings stop at, ascending; none where both are infinite.
struct Limits {
  double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
  bool any() const { return std::isfinite(low) || std::isfinite(high); }
};

Limits limits_of(const NoiseModel& noise, const TriadSource& triad, double interval_s) {
  Limits limits;
  if (noise.range > 0) limits = {-noise.range, noise.range};
  if (triad.limits) {
    if (triad.unit != "count" && si_units.find(triad.unit) == si_units.end())
      throw Error(fmt::format("[[recording]]: limits in \"{}\": counts or SI were expected", triad.unit));
    const double interval = triad.output == Output::increment ? interval_s : 1;  // a reading is a mean here
    limits = {std::max(limits.low, (*triad.limits)[0] / interval), std::min(limits.high, (*triad.limits)[1] / interval)};
  }
  return limits;
}

/// Whole steps of the resolution, inside the limits.
void read_out(double resolution, const Limits& limits, std::span<double> out) {
  if (resolution > 0)
    for (double& x : out) x = std::nearbyint(x / resolution) * resolution;
  if (limits.any())
    for (double& x : out) x = std::clamp(x, limits.low, limits.high);
}

/// Six axes' noise, gyros first.
std::vector<AxisNoise> noise_of(const Truth& truth, const RecordingSource& source, double interval_s, std::uint64_t seed) {
  std::vector<AxisNoise> noise;
  for (const char* triad : {"gyro", "accel"})
    for (const char axis : {'x', 'y', 'z'})
      noise.emplace_back(triad[0] == 'g' ? truth.gyro_noise : truth.accel_noise, interval_s, seed,
                         fmt::format("{}.{} noise of {}", triad, axis, source.file));
  return noise;
}

std::span<double> column(Recording& recording, std::size_t axis) { return axis < 3 ? recording.gyro[axis] : recording.accel[axis - 3]; }

std::vector<std::size_t> saturated(Recording& recording, const Limits& gyro, const Limits& accel) {
  std::vector<std::size_t> samples;
  if (!gyro.any() && !accel.any()) return samples;
  for (std::size_t k = 0; k < recording.size(); ++k)
    for (std::size_t axis = 0; axis < 6; ++axis) {
      const Limits& limits = axis < 3 ? gyro : accel;
      if (const double x = column(recording, axis)[k]; x > limits.low && x < limits.high) continue;
      samples.push_back(k);
      break;
    }
  return samples;
}

}  // namespace

Recording simulate_recording(const Session& procedure, const RecordingSource& source, const Truth& truth, std::uint64_t seed, const RigErrors& rig) {
  validate(procedure, source, truth.model);
  const double rate = source.rate_hz.value_or(default_rate), interval_s = 1 / rate;
  const std::vector<Step> steps = steps_of(procedure, source);
  const RigMotion motion = rig_motion(steps, rig);
  const MeanMotion mean(motion, {earth_rate_enu(truth.latitude.value_or(*procedure.site.latitude)), truth.gravity, truth.model.lever_arm});
  const auto count = static_cast<std::size_t>(std::floor(steps.back().end * rate * (1 + 1e-12)));  // the last sample ends with the last step
  if (count == 0) throw Error("[[recording]]: steps that last at least one sample were expected");
  const Limits gyro_limits = limits_of(truth.gyro_noise, source.gyro, interval_s),
               accel_limits = limits_of(truth.accel_noise, source.accel, interval_s);
  Recording recording = empty_recording(source, rate, count);
  const bool gyro_thermal = truth.model.gyro.temperature || source.gyro_temperature,
             accel_thermal = truth.model.accel.temperature || source.accel_temperature;
  const std::vector<double> gyro_temperature = gyro_thermal ? temperatures(motion, truth.model.gyro, count, interval_s) : std::vector<double>{};
  const std::vector<double> accel_temperature = accel_thermal ? temperatures(motion, truth.model.accel, count, interval_s) : std::vector<double>{};
  if (source.gyro_temperature) recording.gyro_temperature.fill(gyro_temperature);
  if (source.accel_temperature) recording.accel_temperature.fill(accel_temperature);

  const std::vector<AxisNoise> noise = noise_of(truth, source, interval_s, seed);
  // Isolated: a thread that waits here must not take up an outer loop's next session on the same stack.
  tbb::this_task_arena::isolate([&] {
    tbb::parallel_for(std::size_t{0}, noise.size(), [&](std::size_t axis) {  // terms with a memory: an axis is one task
      if (noise[axis].slow()) noise[axis].add_slow(column(recording, axis));
    });
    tbb::parallel_for(std::size_t{0}, (count + block_size - 1) / block_size, [&](std::size_t block) {
      const std::size_t begin = block * block_size, size = std::min(block_size, count - begin);
      std::array<std::array<double, block_size>, 6> ideal;
      MotionColumns ideal_columns;
      for (std::size_t axis = 0; axis < 3; ++axis)
        ideal_columns.rate[axis] = std::span(ideal[axis]).first(size), ideal_columns.force[axis] = std::span(ideal[axis + 3]).first(size);
      mean.over(begin, interval_s, ideal_columns);
      for (std::size_t axis = 0; axis < 6; ++axis) {
        const std::span<double> out = column(recording, axis).subspan(begin, size);
        for (std::size_t k = 0; k < size; ++k) out[k] += ideal[axis][k];
        noise[axis].add_fast(begin, out);
      }
      const auto thermal = [&](const std::vector<double>& readings) {
        std::array<std::span<const double>, 3> columns;
        if (!readings.empty()) columns.fill(std::span(readings).subspan(begin, size));
        return columns;
      };
      const MotionColumns out = columns(recording, begin, size);
      decompensate(truth.model, thermal(accel_temperature), thermal(gyro_temperature), out);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        read_out(truth.gyro_noise.resolution, gyro_limits, out.rate[axis]);
        read_out(truth.accel_noise.resolution, accel_limits, out.force[axis]);
      }
    });
  });
  recording.saturated = saturated(recording, gyro_limits, accel_limits);
  return recording;
}

}  // namespace imulab
