#include "imulab/noise/still_part.hpp"

#include "imulab/core/stamp_text.hpp"
#include "imulab/error.hpp"
#include "imulab/recording.hpp"
#include "imulab/recording/clipping.hpp"
#include "imulab/recording/outliers.hpp"
#include "imulab/recording/recording_view.hpp"
#include "imulab/recording/resampling.hpp"
#include "imulab/recording/rest_or_motion.hpp"
#include "imulab/recording/rests_of_view.hpp"
#include "imulab/recording/slow_motion.hpp"
#include "imulab/rests.hpp"
#include "imulab/session.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <optional>
#include <utility>

namespace imulab {
namespace {

constexpr double shortest_still_s = 30;
constexpr std::size_t fewest_samples = 1024;

double seconds(const RecordingView& recording, const Range& range) { return static_cast<double>(range.size()) * recording.interval_s; }

/// If gaps up to this length are frequent, the readings are used as if none were missing.
constexpr double longest_closed_s = 1, most_closed = 0.3;
/// A piece without gaps is used unless the other is longer by this factor.
constexpr std::size_t times_longer = 4;
/// Largest fraction of samples that may be filled in: each has half the noise variance of its neighbors.
constexpr double most_filled = 0.005;

/// Largest fraction of readings at a limit for which a varying channel does not count as saturated.
constexpr double seldom = 0.001;

std::string clipped_axes(const RecordingView& recording, const Range& range) {
  std::string names;
  for (std::size_t column = gyro_columns; column < gyro_temperature_columns; ++column) {
    if (!recording.has(column)) continue;
    std::size_t clipped = 0;
    for_each_clipped(recording, column, range, [&](std::size_t) { ++clipped; });
    if (static_cast<double>(clipped) > seldom * static_cast<double>(range.size())) names += (names.empty() ? "" : ", ") + axis_name(column);
  }
  return names;
}

[[noreturn]] void too_short(const RecordingView& recording, const Rests& found, const Range& best) {
  const std::vector<Range>& rests = found.ranges;
  const std::string expected = fmt::format("expected at least {:g} s and {} samples at rest", shortest_still_s, fewest_samples);
  const Range all{0, recording.size()};
  const std::string where = std::string(recording.name) + ": ";
  if (seconds(recording, all) < shortest_still_s || all.size() < fewest_samples)
    throw Unsupported(fmt::format("{}has {:.3g} s, {} samples: too short to see noise; {}", where, seconds(recording, all), all.size(), expected));
  const std::size_t saturated = recording.saturated.size();
  if (static_cast<double>(saturated) > seldom * static_cast<double>(all.size())) {
    const std::string axes = clipped_axes(recording, all);
    throw Unsupported(fmt::format("{}{} of {} samples are saturated{}: the noise is cut off there; {} without saturation", where, saturated,
                                  all.size(), axes.empty() ? "" : " (" + axes + ")", expected));
  }
  if (rests.empty())
    throw Unsupported(
        fmt::format("{}moves throughout: no rest was found{}; {}", where, found.motion.empty() ? "" : " (" + found.motion + ")", expected));
  Range longest;
  for (const Range& rest : rests)
    if (rest.size() > longest.size()) longest = rest;
  throw Unsupported(fmt::format("{}the longest of {} rests has {:.3g} s, {:.3g} s of it without gaps and slow motion; {}", where, rests.size(),
                                seconds(recording, longest), seconds(recording, best), expected));
}

/// Returns the missing time in the gaps of a range [s].
double missing_s(const RecordingView& recording, const Range& range) {
  double missing = 0;
  for (auto gap = std::upper_bound(recording.gaps.begin(), recording.gaps.end(), range.begin); gap != recording.gaps.end() && *gap < range.end; ++gap)
    missing += recording.time_s(*gap) - recording.time_s(*gap - 1) - recording.interval_s;
  return missing;
}

/// Joins rests that only a gap separates: motion inside a gap does not matter for the noise.
std::vector<Range> across_gaps(const std::vector<Range>& rests) {
  std::vector<Range> out;
  for (const Range& rest : rests) {
    if (!out.empty() && out.back().end == rest.begin)
      out.back().end = rest.end;
    else
      out.push_back(rest);
  }
  return out;
}

/// Returns the longest part across short gaps if it is much longer than the longest without, else nothing.
std::optional<Range> across_short_gaps(const RecordingView& recording, const Range& part, const Range& without) {
  Range longest;
  for (const Range& piece : without_interruptions(recording, part, longest_closed_s))
    if (piece.size() > longest.size()) longest = piece;
  if (longest.size() <= times_longer * without.size()) return std::nullopt;
  return missing_s(recording, longest) <= most_closed * seconds(recording, longest) ? std::optional(longest) : std::nullopt;
}

/// Returns the interval of the analysis: nominal, or that of an even clock if the usual difference of the stamps is another. The stamps of each
/// eighth are compared with it: jitter of a third of it changes the mean of 128 by 0.4 %; 1 % is half a percent of N.
double one_interval(const RecordingView& recording, const Range& range, bool declared, std::vector<std::string>& notes) {
  constexpr std::size_t parts = 8;
  constexpr double most = 0.01;
  std::array<double, parts> hz;
  std::string rates;
  for (std::size_t part = 0; part < parts; ++part) {
    const std::size_t first = range.begin + part * (range.size() - 1) / parts, last = range.begin + (part + 1) * (range.size() - 1) / parts;
    hz[part] = static_cast<double>(last - first) / (recording.time_s(last) - recording.time_s(first) - missing_s(recording, {first, last + 1}));
    rates += fmt::format("{}{:.4g}", part == 0 ? "" : ", ", hz[part]);
  }
  const auto [least, greatest] = std::minmax_element(hz.begin(), hz.end());
  const double nominal = 1 / recording.interval_s, mean_hz = std::accumulate(hz.begin(), hz.end(), 0.0) / parts;
  if (*greatest / *least - 1 > most)
    throw Unsupported(fmt::format("{}: the rate changes: {} Hz in the eighths of the rest; expected one rate: cut the log, or, {}", recording.name,
                                  rates, even_rows_advice(mean_hz)));
  if (std::max(*greatest / nominal, nominal / *least) - 1 <= most) return recording.interval_s;
  const std::optional<EvenClock> clock = declared ? std::nullopt : even_clock(recording.time_ns.subspan(range.begin, range.size()));
  if (!clock)
    throw Unsupported(fmt::format("{}: the stamps advance at {:.4g} Hz, but {:.4g} Hz {}; expected a session with the correct rate, or, {}",
                                  recording.name, hz[0], nominal, declared ? "are declared" : "is their usual difference",
                                  even_rows_advice(mean_hz)));
  notes.push_back(fmt::format("the stamps scatter by {:.2g} ms (RMS) about an even clock of {:.6g} ms, which is used in their place",
                              1e3 * clock->scatter_s, 1e3 * clock->interval_s));
  return clock->interval_s;
}

std::vector<std::string> cut_notes(const RecordingView& recording, const std::vector<Range>& rests, const Range& used) {
  std::vector<std::string> notes;
  // If a clock counts from 1970 or from power-on, times refer to the log's first stamp unless that is near zero.
  const double begin = recording.time_s(0) - recording.interval_s, from = std::abs(begin) < 1e6 ? 0 : begin;
  notes.push_back(fmt::format("at rest: {} to {} s{}, {} samples; {:.3g} of {:.6g} s were cut",
                              stamp_text(recording.time_s(used.begin) - recording.interval_s - from),
                              stamp_text(recording.time_s(used.end - 1) - from), from == 0 ? "" : " of the log", used.size(),
                              seconds(recording, {0, recording.size() - used.size()}), seconds(recording, {0, recording.size()})));
  double other = 0, at_rest = 0;
  for (const Range& rest : rests) {
    at_rest += seconds(recording, rest);
    if (rest.end <= used.begin || rest.begin >= used.end) other += seconds(recording, rest);
  }
  const double moving = seconds(recording, {0, recording.size()}) - at_rest;
  if (moving > 0.5 * recording.interval_s) notes.push_back(fmt::format("cut: {:.3g} s of motion or knocks", moving));
  if (other > 0) notes.push_back(fmt::format("cut: {:.3g} s of other rests, which are shorter", other));
  if (const double missing = missing_s(recording, used); missing > 0)
    notes.push_back(
        fmt::format("gaps in the part used: {}, together {:.3g} s: its readings are taken as if none was missing. N and Q stand; times are "
                    "{:.2g} % too short",
                    recording.gaps_in({used.begin + 1, used.end}), missing, 100 * missing / (missing + seconds(recording, used))));
  else if (const std::size_t gaps = recording.gaps.size(); gaps > 0)
    notes.push_back(fmt::format("gaps in the recording: {}; the part used has none", gaps));
  if (const std::size_t n = recording.saturated.size(); n > 0)
    notes.push_back(fmt::format("saturated samples in the recording: {}; the part used has none", n));
  return notes;
}

bool rate_is_declared(const RecordingView& recording, const Session& session) {
  return std::any_of(session.recordings.begin(), session.recordings.end(), [&](const RecordingSource& source) {
    return source.rate_hz && (session.recordings.size() == 1 || source.file == recording.name);
  });
}

}  // namespace

StillRange still_range(const RecordingView& recording, const Session& session, const RepairedSamples& repaired) {
  StillRange still;
  Rests found = rests_of(recording, session);
  if (recording.accel_unit == "count")  // for a log at rest, their mean is gravity
    std::erase_if(found.ranges, [&](const Range& rest) {
      std::string motion = motion_in(recording, rest, true);
      const bool moves = !motion.empty();
      if (moves) found.motion = std::move(motion);
      return moves;
    });
  const std::vector<Range> rests = across_gaps(found.ranges);
  bool slow_motion = false;
  for (const Range& rest : rests) {
    const std::vector<Range> parts = between_slow_motion(recording, rest);
    slow_motion = slow_motion || parts != std::vector{rest};
    for (const Range& part : parts)
      if (const Range piece = longest_piece(recording, part); piece.size() > still.range.size()) still.range = piece;
  }
  const Range without_gaps = still.range;
  for (const Range& rest : rests)
    for (const Range& part : between_slow_motion(recording, rest))
      if (const auto piece = across_short_gaps(recording, part, without_gaps); piece && piece->size() > still.range.size()) still.range = *piece;
  if (seconds(recording, still.range) < shortest_still_s || still.range.size() < fewest_samples) too_short(recording, found, still.range);
  still.notes = cut_notes(recording, rests, still.range);
  if (slow_motion) still.notes.push_back("slow motion was cut: the mean over a second changes far more than usual");
  still.interval_s = one_interval(recording, still.range, rate_is_declared(recording, session), still.notes);
  if (repaired.filled > 0) still.notes.push_back(fmt::format("{} lost samples were filled in", repaired.filled));
  if (repaired.replaced > 0) still.notes.push_back(fmt::format("spikes replaced in the recording: {} samples", repaired.replaced));
  return still;
}

bool worth_filling(const RecordingView& recording) {
  return static_cast<double>(short_gaps(recording).filled) <= most_filled * static_cast<double>(recording.size());
}

StillPart still_part(Recording recording, const Session& session) {
  validate(recording);
  const std::vector<ReplacedReading> outliers = outliers_of(recording);
  for (const ReplacedReading& r : outliers)
    (r.column < accel_columns ? recording.gyro : recording.accel)[r.column % accel_columns][r.sample] = r.value;
  const std::vector<std::size_t> replaced = samples_of(outliers);
  std::erase_if(recording.saturated, [&](std::size_t i) { return std::ranges::binary_search(replaced, i); });
  FilledRecording filled{std::move(recording), 0};
  if (worth_filling(filled.recording)) filled = with_short_gaps_filled(std::move(filled.recording));
  StillRange found = still_range(filled.recording, session, {replaced.size(), filled.filled});
  filled.recording.interval_s = found.interval_s;
  return {std::move(found), std::move(filled.recording)};
}

}  // namespace imulab
