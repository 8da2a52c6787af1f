#include "imulab/recording/aid_clock.hpp"

#include "imulab/core/stamp_text.hpp"
#include "imulab/error.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

namespace imulab {
namespace {

constexpr std::int64_t second_ns = 1'000'000'000;
constexpr std::int64_t gps_begin_s = 315'964'800, week_s = 604'800;

std::int64_t in_utc(std::int64_t gps) {
  const double without = 1e-9 * static_cast<double>(gps);
  // Leap seconds are counted at a time of UTC: that of the result.
  return gps - second_ns * leap_seconds(without - leap_seconds(without));
}
std::int64_t in_gps(std::int64_t utc) { return utc + second_ns * leap_seconds(1e-9 * static_cast<double>(utc)); }

struct ClockSpan {
  std::int64_t begin = 0, end = 0;
};

bool overlap(const ClockSpan& a, const ClockSpan& b) { return a.begin <= b.end && b.begin <= a.end; }

/// The origin [ns since 1970] of the recording's clock, by which it overlaps the aid: 1970, the epoch of GPS, or, of a clock of that scale, the week
/// that the aid is in.
std::optional<std::int64_t> origin_of(const ClockSpan& recording, const ClockSpan& aid, bool of_week) {
  const std::int64_t week = (aid.begin / second_ns - gps_begin_s) / week_s * week_s + gps_begin_s;
  std::vector<std::int64_t> origins{0, gps_begin_s};
  if (of_week) origins.insert(origins.end(), {week, week - week_s, week + week_s});
  for (const std::int64_t origin : origins)
    if (overlap({recording.begin + origin * second_ns, recording.end + origin * second_ns}, aid)) return origin * second_ns;
  return std::nullopt;
}

void shift(std::vector<std::int64_t>& stamps, std::int64_t by) {
  for (std::int64_t& stamp : stamps) stamp -= by;
}

ClockSpan span_of(const std::vector<std::int64_t>& stamps) { return {stamps.front(), stamps.back()}; }

[[noreturn]] void fail_apart(const Aid& aid, const ClockSpan& recording, const ClockSpan& stamps) {
  throw Error(
      fmt::format("{}: its stamps, {} to {} s, do not overlap the time of the recording, {} to {} s; expected the aid of this recording, and "
                  "the scale of its clock (time = {{ scale = \"gps\" }}, \"utc\" or \"own\")",
                  aid.file, stamp_text(stamps.begin), stamp_text(stamps.end), stamp_text(recording.begin), stamp_text(recording.end)));
}

}  // namespace

Aid on_recording_clock(Aid aid, const Recording& recording, const RecordingSource& source, std::vector<std::string>& notes) {
  std::vector<std::int64_t>& stamps = aid.record.time;
  if (stamps.empty() || recording.size() == 0) return aid;
  const std::int64_t zero = source.time.zero_ns();
  const ClockSpan own = span_of(recording.time_ns), counted{own.begin + zero, own.end + zero};
  if (aid.scale == TimeScale::recording) {
    if (!overlap(own, span_of(stamps))) fail_apart(aid, own, span_of(stamps));
    return aid;
  }
  const bool known = aid.scale != TimeScale::own && source.time.scale != TimeScale::own;
  // A clock of unknown scale, if it counts from a date, is most often set by a computer: UTC.
  const bool to_gps = source.time.scale == TimeScale::gps;
  if (aid.scale == TimeScale::gps && !to_gps) std::transform(stamps.begin(), stamps.end(), stamps.begin(), in_utc);
  if (aid.scale == TimeScale::utc && to_gps) std::transform(stamps.begin(), stamps.end(), stamps.begin(), in_gps);
  // A program that tracks poses often stamps by the clock of the IMU's driver.
  const bool one_clock = has_attitude(aid.kind) && overlap(counted, span_of(stamps));
  const auto origin = one_clock                     ? std::optional<std::int64_t>(0)
                      : aid.scale == TimeScale::own ? std::nullopt
                                                    : origin_of(counted, span_of(stamps), known);
  if (known && !origin) fail_apart(aid, counted, span_of(stamps));
  shift(stamps, origin ? zero + *origin : stamps.front() - own.begin);
  if (!known && origin && source.time.scale == TimeScale::own) aid.other_scale_s = leap_seconds(1e-9 * static_cast<double>(counted.begin + *origin));
  aid.scale = known ? TimeScale::recording : TimeScale::own;
  if (known) return aid;
  if (aid.delay_sigma) aid.delay_sigma = std::hypot(*aid.delay_sigma, guessed_offset_sigma);
  notes.push_back(
      fmt::format("{}: the scale of {} is not known (time = {{ scale = \"gps\" }} or \"utc\" says it); their offset is estimated, from {} on",
                  aid.file, source.time.scale == TimeScale::own ? "the recording's clock" : "the aid's clock",
                  one_clock ? "that of their stamps"
                  : origin  ? "that of their dates"
                            : "both beginning together"));
  return aid;
}

}  // namespace imulab
