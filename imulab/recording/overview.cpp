#include "imulab/recording/overview.hpp"

#include "imulab/compensate.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <utility>

namespace imulab {

namespace {

/// A triad's columns, or temperatures.
struct ColumnGroup {
  Columns3 buffers;
  std::array<std::span<const double>, 3> samples;

  ColumnGroup(const RecordingView& recording, std::size_t first, const Range& range) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (recording.has(first + axis))
        samples[axis] = recording.samples(first + axis, range, buffers[axis]);
      else if (first < gyro_temperature_columns)
        samples[axis] = buffers[axis] = std::vector<double>(range.size(), 0);  // a triad that is not there
  }
  ColumnGroup(ColumnGroup&&) = delete;
};

/// The extremes of some samples, in the order in which they came.
std::pair<double, double> extremes(std::span<const double> samples) {
  const auto [least, greatest] = std::minmax_element(samples.begin(), samples.end());
  return least < greatest ? std::pair{*least, *greatest} : std::pair{*greatest, *least};
}

void add(Columns3& to, const std::array<std::span<const double>, 3>& samples, bool all) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (samples[axis].empty()) continue;
    if (all) {
      to[axis].insert(to[axis].end(), samples[axis].begin(), samples[axis].end());
      continue;
    }
    const auto [first, second] = extremes(samples[axis]);
    to[axis].push_back(first);
    to[axis].push_back(second);
  }
}

std::array<std::span<const double>, 3> spans_of(const Columns3& columns) { return {columns[0], columns[1], columns[2]}; }

}  // namespace

MotionSamples compensated_samples(const SensorModel& model, const RecordingView& recording, const Range& range) {
  MotionSamples out;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    out.rate[axis].resize(range.size());
    out.force[axis].resize(range.size());
  }
  const ColumnGroup gyro(recording, gyro_columns, range), accel(recording, accel_columns, range),
      gyro_temperature(recording, gyro_temperature_columns, range), accel_temperature(recording, accel_temperature_columns, range);
  compensate(model, {gyro.samples, accel.samples, gyro_temperature.samples, accel_temperature.samples},
             {{out.rate[0], out.rate[1], out.rate[2]}, {out.force[0], out.force[1], out.force[2]}});
  return out;
}

Overview overview(const SensorModel& model, const RecordingView& recording, std::size_t intervals) {
  Overview out;
  const std::size_t n = recording.size();
  if (n > 0) out.first_s = recording.time_s(0);
  const bool all = n <= 2 * intervals;
  if (!all) out.samples_per_interval = (n + intervals - 1) / intervals;
  const std::size_t step = all ? std::max<std::size_t>(n, 1) : out.samples_per_interval;
  const std::size_t temperature = recording.has(accel_temperature_columns) ? accel_temperature_columns : gyro_temperature_columns;
  for (std::size_t begin = 0; begin < n; begin += step) {
    const Range range{begin, std::min(n, begin + step)};
    const MotionSamples motion = compensated_samples(model, recording, range);
    add(out.rate, spans_of(motion.rate), all);
    add(out.force, spans_of(motion.force), all);
    add(out.temperature, ColumnGroup(recording, temperature, range).samples, all);
    if (all) {
      for (std::size_t i = begin; i < range.end; ++i) out.time.push_back(recording.time_s(i));
      continue;
    }
    const double first = recording.time_s(begin), length = recording.time_s(range.end - 1) - first;
    out.time.push_back(first + 0.25 * length);
    out.time.push_back(first + 0.75 * length);
  }
  return out;
}

}  // namespace imulab
