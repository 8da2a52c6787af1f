#include "imulab/rig/ideal_recording.hpp"

#include "imulab/core/parallel.hpp"
#include "imulab/error.hpp"
#include "imulab/rig/machine.hpp"
#include "imulab/rig/mean_motion.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace imulab {

namespace {

constexpr double most_recorded = 1e8;  // ten columns of them are 8 GB

/// A part of the samples that one task computes.
struct Block {
  std::size_t sample, place, size;  // number of its first sample, its row in the recording, how many
};

std::vector<Block> blocks_of(std::span<const Range> samples) {
  std::vector<Block> blocks;
  std::size_t place = 0;
  for (const Range& range : samples)
    for (std::size_t sample = range.begin; sample < range.end; place += blocks.back().size, sample += blocks.back().size)
      blocks.push_back({sample, place, std::min(samples_per_task, range.end - sample)});
  return blocks;
}

/// Names, units, sizes and stamps: everything but the readings.
Recording empty_recording(const RecordingSource& source, double rate, std::span<const Range> samples) {
  Recording r;
  r.name = source.file;
  r.interval_s = 1 / rate;
  r.gyro_increment = source.gyro.output == Output::increment;
  r.accel_increment = source.accel.output == Output::increment;
  r.gyro_unit = "rad/s";
  r.accel_unit = "m/s^2";
  for (const Range& range : samples) {
    if (!r.time_ns.empty()) r.gaps.push_back(r.size());
    for (std::size_t i = range.begin; i < range.end; ++i) r.time_ns.push_back(std::llround(1e9 * static_cast<double>(i + 1) / rate));
  }
  for (auto* triad : {&r.gyro, &r.accel})
    for (auto& column : *triad) column.resize(r.size());
  return r;
}

}  // namespace

std::vector<Range> recorded_samples(const RecordingSource& source, std::span<const Step> steps) {
  constexpr double rounding = 1e-12;  // of a time as a number of samples, relative
  const double rate = source.rate_hz.value_or(default_sample_rate);
  if (!(rate > 0)) throw Error(fmt::format("a sampling rate of {:g} Hz; expected one above 0", rate));
  constexpr double most_counted = 1e15;  // of samples: a double holds it
  for (const Step& step : steps)
    if (!(std::max(std::abs(step.start), std::abs(step.end)) * rate < most_counted))
      throw Error(fmt::format("a step from {:g} to {:g} s at {:g} Hz; expected less than {:g} samples", step.start, step.end, rate, most_counted));
  struct Samples {
    double begin, end;  // whole, and maybe more than an index counts
  };
  const auto last = [&](const Step& step) { return std::floor(std::max(0.0, step.end) * rate * (1 + rounding)); };
  std::vector<Samples> samples;
  if (source.extent == Extent::all && !steps.empty()) samples.push_back({0, last(steps.back())});
  for (const Step& step : steps) {
    if (source.extent == Extent::all) break;
    const Samples inside{std::ceil(std::max(0.0, step.start) * rate * (1 - rounding)), last(step)};
    if (inside.begin >= inside.end) continue;
    if (!samples.empty() && samples.back().end == inside.begin) {
      samples.back().end = inside.end;
    } else {
      samples.push_back(inside);
    }
  }
  if (samples.empty() || samples.back().end == 0) throw Error("the steps last less than one sample; expected at least one");
  double count = 0;
  for (const Samples& range : samples) count += range.end - range.begin;
  if (count > most_recorded)
    throw Error(fmt::format("{:.3g} samples; expected at most {:.0e}: shorter steps or a lower sampling rate", count, most_recorded));
  constexpr auto most_index = static_cast<double>(std::numeric_limits<std::size_t>::max());
  if (samples.back().end >= most_index)
    throw Error(fmt::format("the last sample is number {:.3g} from time 0; expected at most {:.3g}", samples.back().end, most_index));
  std::vector<Range> ranges;
  for (const Samples& range : samples) ranges.push_back({static_cast<std::size_t>(range.begin), static_cast<std::size_t>(range.end)});
  return ranges;
}

Recording ideal_recording(const Session& procedure, const RecordingSource& source, const Surroundings& surroundings, const RigErrors& errors) {
  const std::vector<Range> samples = recorded_samples(source, procedure.steps_of(source));
  const double rate = source.rate_hz.value_or(default_sample_rate);
  const RigDeclaration* const rig = procedure.rig_of(source);
  Surroundings place = surroundings;
  if (rig != nullptr && is_machine(rig->kind)) place.lever_arm.setZero();
  const MeanMotion mean(recorded_motion(procedure, source, errors), place);
  Recording recording = empty_recording(source, rate, samples);
  const std::vector<Block> blocks = blocks_of(samples);
  // Isolated: a thread that waits here must not start an outer loop's next recording on the same stack.
  isolate_parallel([&] {
    parallel_for(blocks.size(), [&](std::size_t block) {
      const auto [sample, place_of, size] = blocks[block];
      MotionColumns out;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        out.rate[axis] = std::span(recording.gyro[axis]).subspan(place_of, size);
        out.force[axis] = std::span(recording.accel[axis]).subspan(place_of, size);
      }
      mean.over(sample, 1 / rate, out);
    });
  });
  return recording;
}

Recording coarse_recording(const Session& procedure, const Surroundings& surroundings, double slowest) {
  constexpr double turned = 0.05;  // rad
  const double fastest = 16 * slowest;
  RecordingSource source;
  if (!procedure.recordings.empty()) source.file = procedure.recordings.front().file, source.rig = procedure.recordings.front().rig;
  for (double rate = slowest;; rate *= 2) {
    source.rate_hz = rate;
    Recording recording = ideal_recording(procedure, source, surroundings);
    double largest = 0;
    for (const std::vector<double>& column : recording.gyro)
      for (const double x : column) largest = std::max(largest, std::abs(x));
    if (largest * recording.interval_s < turned || rate >= fastest) return recording;
  }
}

}  // namespace imulab
