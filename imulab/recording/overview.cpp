#include "imulab/recording/overview.hpp"

#include "imulab/model/compensate.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <utility>

namespace imulab {

namespace {

std::array<std::span<const double>, 3> part(const Columns3& columns, const Range& range) {
  std::array<std::span<const double>, 3> out;
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (!columns[axis].empty()) out[axis] = std::span(columns[axis]).subspan(range.begin, range.size());
  return out;
}

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

MotionSamples compensated_samples(const SensorModel& model, const Recording& recording, const Range& range) {
  MotionSamples out;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    out.rate[axis].resize(range.size());
    out.force[axis].resize(range.size());
  }
  compensate(
      model,
      {part(recording.gyro, range), part(recording.accel, range), part(recording.gyro_temperature, range), part(recording.accel_temperature, range)},
      {{out.rate[0], out.rate[1], out.rate[2]}, {out.force[0], out.force[1], out.force[2]}});
  return out;
}

Overview overview(const SensorModel& model, const Recording& recording, std::size_t intervals) {
  Overview out;
  const std::size_t n = recording.size();
  const bool all = n <= 2 * intervals;
  if (!all) out.samples_per_interval = (n + intervals - 1) / intervals;
  const std::size_t step = all ? std::max<std::size_t>(n, 1) : out.samples_per_interval;
  const Columns3& temperature = recording.accel_temperature[0].empty() ? recording.gyro_temperature : recording.accel_temperature;
  for (std::size_t begin = 0; begin < n; begin += step) {
    const Range range{begin, std::min(n, begin + step)};
    const MotionSamples motion = compensated_samples(model, recording, range);
    add(out.rate, spans_of(motion.rate), all);
    add(out.force, spans_of(motion.force), all);
    add(out.temperature, part(temperature, range), all);
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
