#include "imulab/simulate/simulate.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/parallel.hpp"
#include "imulab/earth/earth.hpp"
#include "imulab/model/compensate.hpp"
#include "imulab/model/sensor_noise.hpp"
#include "imulab/rig/ideal_recording.hpp"
#include "imulab/rig/machine_motion.hpp"
#include "imulab/simulate/temperature.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>

namespace imulab {

namespace {

using namespace simulate;

const std::set<std::string, std::less<>> si_units{"rad/s", "rad", "m/s^2", "m/s"};

/// The limits of the readings, ascending; none if both are infinite.
struct Limits {
  double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
  bool any() const { return std::isfinite(low) || std::isfinite(high); }
};

Limits limits_of(const NoiseModel& noise, const TriadSource& triad, double interval_s) {
  Limits limits;
  if (noise.range > 0) limits = {-noise.range, noise.range};
  if (triad.limits) {
    if (triad.unit != "count" && si_units.find(triad.unit) == si_units.end())
      throw Error(fmt::format("limits in \"{}\"; expected counts or SI", triad.unit));
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

std::span<double> column(Recording& recording, std::size_t axis) { return axis < 3 ? recording.gyro[axis] : recording.accel[axis - 3]; }

/// Six axes' noise, gyros first.
std::vector<AxisNoise> noise_of(const Truth& truth, const RecordingSource& source, double interval_s, std::uint64_t seed) {
  std::vector<AxisNoise> noise;
  for (const char* triad : {"gyro", "accel"})
    for (const char axis : {'x', 'y', 'z'})
      noise.emplace_back(triad[0] == 'g' ? truth.gyro_noise : truth.accel_noise, interval_s, seed,
                         fmt::format("{}.{} noise of {}", triad, axis, source.file));
  return noise;
}

/// Adds an axis's noise to its column, which holds these samples.
void add_noise(const AxisNoise& noise, std::span<const Range> samples, std::span<double> out) {
  if (noise.slow()) {
    std::vector<double> all(samples.back().end);
    noise.add_slow(all);
    std::size_t place = 0;
    for (const Range& range : samples)
      for (std::size_t i = range.begin; i < range.end; ++i) out[place++] += all[i];
  }
  std::size_t place = 0;
  for (const Range& range : samples) {
    noise.add_fast(range.begin, out.subspan(place, range.size()));
    place += range.size();
  }
}

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
  if (!procedure.site.latitude) throw Error("the site has no latitude; the Earth's rate depends on it; expected a latitude");
  Recording recording = ideal_recording(
      procedure, source, {earth_rate_enu(truth.latitude.value_or(*procedure.site.latitude)), truth.gravity, truth.model.lever_arm}, rig);
  if (source.gyro.unit == "count") recording.gyro_unit = "count";
  if (source.accel.unit == "count") recording.accel_unit = "count";
  const std::vector<Range> samples = recorded_samples(source, procedure.steps_of(source));
  const Limits gyro_limits = limits_of(truth.gyro_noise, source.gyro, recording.interval_s),
               accel_limits = limits_of(truth.accel_noise, source.accel, recording.interval_s);
  std::vector<TemperatureProfile::State> temperatures;
  if (truth.model.gyro.temperature || truth.model.accel.temperature || source.gyro_temperature || source.accel_temperature)
    temperatures =
        temperatures_at(samples, TemperatureProfile(recorded_motion(procedure, source, rig), procedure.rig_of(source)), recording.interval_s);
  recording.gyro_temperature = thermal_readings(source.gyro_temperature, temperatures, samples, seed, "gyro temperature of " + source.file);
  recording.accel_temperature = thermal_readings(source.accel_temperature, temperatures, samples, seed, "accel temperature of " + source.file);
  const std::vector<double> gyro_followed = followed_readings(truth.model.gyro, source.gyro_temperature, temperatures),
                            accel_followed = followed_readings(truth.model.accel, source.accel_temperature, temperatures);
  const std::vector<AxisNoise> noise = noise_of(truth, source, recording.interval_s, seed);
  // Isolated: a thread that waits here must not start an outer loop's next session on the same stack.
  isolate_parallel([&] {
    parallel_for(noise.size(), [&](std::size_t axis) { add_noise(noise[axis], samples, column(recording, axis)); });
    parallel_for((recording.size() + samples_per_task - 1) / samples_per_task, [&](std::size_t block) {
      const std::size_t begin = block * samples_per_task, size = std::min(samples_per_task, recording.size() - begin);
      const auto part = [&](const std::vector<double>& readings) {
        std::array<std::span<const double>, 3> columns;
        if (!readings.empty()) columns.fill(std::span(readings).subspan(begin, size));
        return columns;
      };
      MotionColumns out;
      for (std::size_t axis = 0; axis < 3; ++axis)
        out.rate[axis] = column(recording, axis).subspan(begin, size), out.force[axis] = column(recording, axis + 3).subspan(begin, size);
      decompensate(truth.model, part(accel_followed), part(gyro_followed), out);
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
