#include "imulab/simulate/simulate.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/random.hpp"
#include "imulab/earth/earth.hpp"
#include "imulab/simulate/mean_motion.hpp"

#include <fmt/core.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cmath>

namespace imulab {

namespace {

constexpr std::size_t block_size = 4096;  // samples one task computes; even, since normal draws come in pairs
constexpr double default_rate = 100;      // Hz

MotionColumns columns(Recording& recording, std::size_t begin, std::size_t count) {
  MotionColumns out;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    out.rate[axis] = std::span(recording.gyro[axis]).subspan(begin, count);
    out.force[axis] = std::span(recording.accel[axis]).subspan(begin, count);
  }
  return out;
}

/// Adds white noise of this sigma; draw number i belongs to sample i.
void add_noise(const RandomStream& noise, double sigma, std::size_t begin, std::span<double> out) {
  for (std::size_t k = 0; k < out.size(); k += 2) {
    const auto pair = noise.normal_pair((begin + k) / 2);
    out[k] += sigma * pair[0];
    if (k + 1 < out.size()) out[k + 1] += sigma * pair[1];
  }
}

/// The thermal reading of each sample: its step's set point; before the first set point the model's reference.
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

Vector3d tau(const TriadModel& model, double temperature) {
  return Vector3d::Constant(model.temperature ? temperature - model.temperature->reference : 0);
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

/// Motion in SI -> raw, in place.
void decompensate_columns(const SensorModel& model, std::span<const double> gyro_temperature, std::span<const double> accel_temperature,
                          const MotionColumns& columns) {
  for (std::size_t k = 0; k < gyro_temperature.size(); ++k) {
    const Motion sensed{{columns.force[0][k], columns.force[1][k], columns.force[2][k]},
                        {columns.rate[0][k], columns.rate[1][k], columns.rate[2][k]}};
    const RawSample raw = decompensate(model, sensed, tau(model.accel, accel_temperature[k]), tau(model.gyro, gyro_temperature[k]));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      columns.force[axis][k] = raw.accel(static_cast<Eigen::Index>(axis));
      columns.rate[axis][k] = raw.gyro(static_cast<Eigen::Index>(axis));
    }
  }
}

}  // namespace

Recording simulate_recording(const Session& procedure, const RecordingSource& source, const Truth& truth, std::uint64_t seed, const RigErrors& rig) {
  validate(procedure, source, truth.model);
  const double rate = source.rate_hz.value_or(default_rate), interval_s = 1 / rate;
  const std::vector<Step> steps = steps_of(procedure, source);
  const RigMotion motion = rig_motion(steps, rig);
  const MeanMotion mean(motion, {earth_rate_enu(*procedure.site.latitude), truth.gravity, truth.model.lever_arm});
  const auto count = static_cast<std::size_t>(std::floor(steps.back().end * rate * (1 + 1e-12)));  // the last sample ends with the last step
  if (count == 0) throw Error("[[recording]]: steps that last at least one sample were expected");
  Recording recording = empty_recording(source, rate, count);
  const std::vector<double> gyro_temperature = temperatures(motion, truth.model.gyro, count, interval_s);
  const std::vector<double> accel_temperature = temperatures(motion, truth.model.accel, count, interval_s);
  if (source.gyro_temperature) recording.gyro_temperature.fill(gyro_temperature);
  if (source.accel_temperature) recording.accel_temperature.fill(accel_temperature);

  // Isolated: a thread that waits here must not take up an outer loop's next session on the same stack.
  tbb::this_task_arena::isolate([&] {
    tbb::parallel_for(std::size_t{0}, (count + block_size - 1) / block_size, [&](std::size_t block) {
      const std::size_t begin = block * block_size, size = std::min(block_size, count - begin);
      const MotionColumns out = columns(recording, begin, size);
      mean.over(begin, interval_s, out);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto noise = [&](const char* triad) { return RandomStream(seed, fmt::format("{}.{} noise of {}", triad, "xyz"[axis], source.file)); };
        add_noise(noise("gyro"), truth.gyro_noise_density * std::sqrt(rate), begin, out.rate[axis]);
        add_noise(noise("accel"), truth.accel_noise_density * std::sqrt(rate), begin, out.force[axis]);
      }
      decompensate_columns(truth.model, std::span(gyro_temperature).subspan(begin, size), std::span(accel_temperature).subspan(begin, size), out);
    });
  });
  return recording;
}

}  // namespace imulab
