#include "imulab/simulate/simulate.hpp"

#include "imulab/core/error.hpp"
#include "imulab/earth/earth.hpp"
#include "imulab/rig/machine.hpp"
#include "imulab/rig/machine_motion.hpp"
#include "imulab/simulate/mean_motion.hpp"
#include "imulab/simulate/sensor_noise.hpp"
#include "imulab/simulate/temperature.hpp"

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
constexpr double most_samples = 1e8;      // ten columns of them are 8 GB
const std::set<std::string, std::less<>> si_units{"rad/s", "rad", "m/s^2", "m/s"};

MotionColumns columns(Recording& recording, std::size_t begin, std::size_t count) {
  MotionColumns out;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    out.rate[axis] = std::span(recording.gyro[axis]).subspan(begin, count);
    out.force[axis] = std::span(recording.accel[axis]).subspan(begin, count);
  }
  return out;
}

/// The samples that are written down, by number: all up to the end of the last step, or those whose interval lies inside a step.
std::vector<Range> written_samples(const RecordingSource& source, std::span<const Step> steps, double rate) {
  constexpr double rounding = 1e-12;  // of a time as a number of samples, relative
  const auto last = [&](const Step& step) { return static_cast<std::size_t>(std::floor(std::max(0.0, step.end) * rate * (1 + rounding))); };
  if (source.extent == Extent::all) return {{0, last(steps.back())}};
  std::vector<Range> written;
  for (const Step& step : steps) {
    const Range inside{static_cast<std::size_t>(std::ceil(std::max(0.0, step.start) * rate * (1 - rounding))), last(step)};
    if (inside.begin >= inside.end) continue;
    if (!written.empty() && written.back().end == inside.begin) {
      written.back().end = inside.end;
    } else {
      written.push_back(inside);
    }
  }
  return written;
}

/// A part of the written samples that one task computes.
struct Block {
  std::size_t sample, place, size;  // number of its first sample, where that is written, how many
};

std::vector<Block> blocks_of(std::span<const Range> written) {
  std::vector<Block> blocks;
  std::size_t place = 0;
  for (const Range& range : written)
    for (std::size_t sample = range.begin; sample < range.end; place += blocks.back().size, sample += blocks.back().size)
      blocks.push_back({sample, place, std::min(block_size, range.end - sample)});
  return blocks;
}

void validate(const Session& procedure, const RecordingSource& source) {
  if (!procedure.site.latitude) throw Error("[site]: latitude_deg was expected: Earth's rate depends on it");
  if (source.rate_hz && !(*source.rate_hz > 0)) throw Error("[[recording]]: rate_hz above 0 was expected");
}

/// Nothing but what is known beforehand: names, units, sizes, stamps.
Recording empty_recording(const RecordingSource& source, double rate, std::span<const Range> written) {
  Recording r;
  r.name = source.file;
  r.interval_s = 1 / rate;
  r.gyro_increment = source.gyro.output == Output::increment;
  r.accel_increment = source.accel.output == Output::increment;
  r.gyro_unit = source.gyro.unit == "count" ? "count" : "rad/s";
  r.accel_unit = source.accel.unit == "count" ? "count" : "m/s^2";
  for (const Range& range : written) {
    if (!r.time_ns.empty()) r.gaps.push_back(r.size());
    for (std::size_t i = range.begin; i < range.end; ++i) r.time_ns.push_back(std::llround(1e9 * static_cast<double>(i + 1) / rate));
  }
  for (auto* triad : {&r.gyro, &r.accel})
    for (auto& column : *triad) column.resize(r.size());
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
  validate(procedure, source);
  const double rate = source.rate_hz.value_or(default_rate), interval_s = 1 / rate;
  const RigDeclaration* const machine = rig_of(procedure, source);
  const bool own_radii = machine != nullptr && is_machine(machine->kind);  // which say where the accelerometers are
  const RigMotion motion = recorded_motion(procedure, source, rig);
  const MeanMotion mean(motion, {earth_rate_enu(truth.latitude.value_or(*procedure.site.latitude)), truth.gravity,
                                 own_radii ? Matrix3d(Matrix3d::Zero()) : truth.model.lever_arm});
  const std::vector<Range> written = written_samples(source, steps_of(procedure, source), rate);
  if (written.empty() || written.back().end == 0) throw Error("[[recording]]: steps that last at least one sample were expected");
  double samples = 0;
  for (const Range& range : written) samples += static_cast<double>(range.size());
  if (samples > most_samples) throw Error(fmt::format("[[recording]]: {:.3g} samples, at most {:.0e} were expected: shorter steps or a lower rate_hz", samples, most_samples));
  const Limits gyro_limits = limits_of(truth.gyro_noise, source.gyro, interval_s),
               accel_limits = limits_of(truth.accel_noise, source.accel, interval_s);
  Recording recording = empty_recording(source, rate, written);
  const bool thermal = truth.model.gyro.temperature || truth.model.accel.temperature || source.gyro_temperature || source.accel_temperature;
  const std::vector<TemperatureCourse::State> temperatures =
      temperatures_at(thermal ? written : std::vector<Range>{}, TemperatureCourse(motion, machine), interval_s);
  recording.gyro_temperature = thermal_readings(source.gyro_temperature, temperatures, written, seed, "gyro temperature of " + source.file);
  recording.accel_temperature = thermal_readings(source.accel_temperature, temperatures, written, seed, "accel temperature of " + source.file);
  const std::vector<double> gyro_followed = followed_readings(truth.model.gyro, source.gyro_temperature, temperatures),
                            accel_followed = followed_readings(truth.model.accel, source.accel_temperature, temperatures);

  const std::vector<Block> blocks = blocks_of(written);
  const std::vector<AxisNoise> noise = noise_of(truth, source, interval_s, seed);
  // Isolated: a thread that waits here must not take up an outer loop's next session on the same stack.
  tbb::this_task_arena::isolate([&] {
    tbb::parallel_for(std::size_t{0}, noise.size(), [&](std::size_t axis) {  // terms with a memory: an axis is one task
      if (!noise[axis].slow()) return;
      std::vector<double> all(written.back().end);
      noise[axis].add_slow(all);
      auto place = column(recording, axis).begin();
      for (const Range& range : written) place = std::copy_n(all.begin() + static_cast<std::ptrdiff_t>(range.begin), range.size(), place);
    });
    tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t block) {
      const auto [sample, begin, size] = blocks[block];
      std::array<std::array<double, block_size>, 6> ideal;
      MotionColumns ideal_columns;
      for (std::size_t axis = 0; axis < 3; ++axis)
        ideal_columns.rate[axis] = std::span(ideal[axis]).first(size), ideal_columns.force[axis] = std::span(ideal[axis + 3]).first(size);
      mean.over(sample, interval_s, ideal_columns);
      for (std::size_t axis = 0; axis < 6; ++axis) {
        const std::span<double> out = column(recording, axis).subspan(begin, size);
        for (std::size_t k = 0; k < size; ++k) out[k] += ideal[axis][k];
        noise[axis].add_fast(sample, out);
      }
      const auto part = [&, first = begin, count = size](const std::vector<double>& readings) {
        std::array<std::span<const double>, 3> columns;
        if (!readings.empty()) columns.fill(std::span(readings).subspan(first, count));
        return columns;
      };
      const MotionColumns out = columns(recording, begin, size);
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
