#include "imulab/recording/joined.hpp"

#include "imulab/error.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace imulab {

namespace {

void expect_alike(const Recording& first, const Recording& other) {
  const auto differ = [&](const char* what) {
    throw Error(fmt::format("{} and {} have different {}; expected recordings of one IMU in the same form, or --recording with one of them",
                            first.name, other.name, what));
  };
  if (first.gyro_unit != other.gyro_unit || first.accel_unit != other.accel_unit) differ("units");
  if (first.gyro_increment != other.gyro_increment || first.accel_increment != other.accel_increment) differ("kinds of output");
  if (std::abs(other.interval_s / first.interval_s - 1) > 0.01) differ("rates");
  if (first.gyro_temperature[0].empty() != other.gyro_temperature[0].empty() ||
      first.accel_temperature[0].empty() != other.accel_temperature[0].empty())
    differ("thermal readings");
}

void append(Columns3& to, const Columns3& from) {
  for (std::size_t axis = 0; axis < 3; ++axis) to[axis].insert(to[axis].end(), from[axis].begin(), from[axis].end());
}

void append(Recording& to, const Recording& from, std::int64_t shift_ns) {
  const std::size_t first = to.size();
  for (const std::int64_t t : from.time_ns) to.time_ns.push_back(t + shift_ns);
  append(to.gyro, from.gyro), append(to.accel, from.accel);
  append(to.gyro_temperature, from.gyro_temperature), append(to.accel_temperature, from.accel_temperature);
  for (const std::size_t i : from.saturated) to.saturated.push_back(first + i);
  if (first > 0) to.gaps.push_back(first), to.starts.push_back(first);
  for (const std::size_t i : from.gaps)
    if (first + i > 0 && (to.gaps.empty() || to.gaps.back() != first + i)) to.gaps.push_back(first + i);
}

}  // namespace

Joined join(const Session& session, std::span<const Recording> recordings) {
  constexpr std::int64_t pause_ns = 60'000'000'000;  // any that no rest or turn spans
  if (recordings.empty()) throw Error("no recordings to join");
  Joined out{session, {}, {}};
  const Recording& first = recordings.front();
  out.recording.name = first.name;
  out.recording.interval_s = first.interval_s;
  out.recording.gyro_increment = first.gyro_increment, out.recording.accel_increment = first.accel_increment;
  out.recording.gyro_unit = first.gyro_unit, out.recording.accel_unit = first.accel_unit;
  out.session.steps.clear();
  out.session.recordings = {session.source_of(first.name)};
  for (const Recording& recording : recordings) {
    if (recording.size() == 0) throw Error(recording.name + ": no samples; expected a recording");
    expect_alike(first, recording);
    const std::int64_t shift = out.recording.size() == 0 ? 0 : out.recording.time_ns.back() + pause_ns - recording.time_ns.front();
    const double shift_s = 1e-9 * static_cast<double>(shift);
    const std::size_t begin = out.recording.size();
    append(out.recording, recording, shift);
    out.parts.push_back({recording.name, out.recording.time_s(begin), shift_s});
    for (Step step : session.steps_of(session.source_of(recording.name))) {
      step.start += shift_s, step.end += shift_s;
      step.recording = first.name;
      out.session.steps.push_back(step);
    }
  }
  return out;
}

const JoinedPart& part_at(const std::vector<JoinedPart>& parts, double joined_s) {
  const auto after = std::upper_bound(parts.begin() + 1, parts.end(), joined_s, [](double t, const JoinedPart& p) { return t < p.begin_s; });
  return *(after - 1);
}

}  // namespace imulab
