#include "imulab/simulate/simulate.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/random.hpp"
#include "imulab/earth/earth.hpp"
#include "imulab/simulate/mean_motion.hpp"

#include <fmt/core.h>
#include <oneapi/tbb/parallel_for.h>

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
  double now = model.temperature ? model.temperature->reference : ThermalReading{}.reference;
  std::size_t sample = 0;
  for (const MotionPiece& piece : motion.pieces) {
    now = piece.temperature.value_or(now);
    while (sample < count && static_cast<double>(sample + 1) * interval_s <= piece.end + 0.5 * interval_s) out[sample++] = now;
  }
  std::fill(out.begin() + static_cast<std::ptrdiff_t>(sample), out.end(), now);
  return out;
}

double tau(const TriadModel& model, const std::vector<double>& temperature, std::size_t sample) {
  return model.temperature ? temperature[sample] - model.temperature->reference : 0;
}

}  // namespace

Recording simulate_recording(const Session& procedure, const RecordingSource& source, const Truth& truth, std::uint64_t seed) {
  if (!procedure.site.latitude) throw Error("[site]: latitude_deg was expected: Earth's rate depends on it");
  const double rate = source.rate_hz.value_or(default_rate), interval_s = 1 / rate;
  if (!(rate > 0)) throw Error("[[recording]]: rate_hz above 0 was expected");
  const RigMotion motion = rig_motion(steps_of(procedure, source));
  const MeanMotion mean(motion, {earth_rate_enu(*procedure.site.latitude), truth.gravity, truth.model.lever_arm});

  Recording recording;
  recording.name = source.file;
  recording.interval_s = interval_s;
  recording.gyro_increment = source.gyro.output == Output::increment;
  recording.accel_increment = source.accel.output == Output::increment;
  recording.gyro_unit = source.gyro.unit == "count" ? "count" : "rad/s";
  recording.accel_unit = source.accel.unit == "count" ? "count" : "m/s^2";
  const auto count = static_cast<std::size_t>(std::floor(motion.end() * rate * (1 + 1e-12)));  // the last sample ends with the last step
  recording.time_ns.resize(count);
  for (auto* triad : {&recording.gyro, &recording.accel})
    for (auto& column : *triad) column.resize(count);
  const std::vector<double> gyro_temperature = temperatures(motion, truth.model.gyro, count, interval_s);
  const std::vector<double> accel_temperature = temperatures(motion, truth.model.accel, count, interval_s);
  if (source.gyro_temperature) recording.gyro_temperature.fill(gyro_temperature);
  if (source.accel_temperature) recording.accel_temperature.fill(accel_temperature);

  const double gyro_sigma = truth.gyro_noise_density * std::sqrt(rate), accel_sigma = truth.accel_noise_density * std::sqrt(rate);
  const auto fill = [&](std::size_t block) {
    const std::size_t begin = block * block_size, size = std::min(block_size, count - begin);
    const MotionColumns out = columns(recording, begin, size);
    mean.over(begin, interval_s, out);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto noise = [&](const char* triad) { return RandomStream(seed, fmt::format("{}.{} noise of {}", triad, "xyz"[axis], source.file)); };
      add_noise(noise("gyro"), gyro_sigma, begin, out.rate[axis]);
      add_noise(noise("accel"), accel_sigma, begin, out.force[axis]);
    }
    for (std::size_t k = 0; k < size; ++k) {
      const Motion sensed{{out.force[0][k], out.force[1][k], out.force[2][k]}, {out.rate[0][k], out.rate[1][k], out.rate[2][k]}};
      const RawSample raw = decompensate(truth.model, sensed, Vector3d::Constant(tau(truth.model.accel, accel_temperature, begin + k)),
                                         Vector3d::Constant(tau(truth.model.gyro, gyro_temperature, begin + k)));
      for (std::size_t axis = 0; axis < 3; ++axis) {
        out.force[axis][k] = raw.accel(static_cast<Eigen::Index>(axis));
        out.rate[axis][k] = raw.gyro(static_cast<Eigen::Index>(axis));
      }
      recording.time_ns[begin + k] = std::llround(1e9 * static_cast<double>(begin + k + 1) / rate);
    }
  };
  tbb::parallel_for(std::size_t{0}, (count + block_size - 1) / block_size, fill);
  return recording;
}

}  // namespace imulab
