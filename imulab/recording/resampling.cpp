#include "imulab/recording/resampling.hpp"

#include "imulab/error.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace imulab {

std::optional<EvenClock> replacing_clock(const Recording& r, Stamps wanted) {
  if (wanted == Stamps::recorded) return std::nullopt;
  std::optional<EvenClock> clock = even_clock(r.time_ns);
  // A recording with pauses has a mean interval far from its nominal one; a serial line's stamps are a few percent off.
  if (clock && std::abs(clock->interval_s / r.interval_s - 1) > 0.2) clock.reset();
  if (!clock && wanted == Stamps::uniform)
    throw Error(fmt::format(
        "{}: its stamps are not those of an even clock (samples are missing, or the clock wanders); expected the recorded stamps to be kept",
        r.name));
  return clock && (wanted == Stamps::uniform || clock->scatter_s > 0.05 * clock->interval_s) ? clock : std::nullopt;
}

Recording with_even_stamps(Recording r, const EvenClock& clock, bool interval_declared) {
  for (std::size_t i = 0; i < r.size(); ++i) r.time_ns[i] = clock.stamp_ns(i);
  if (!interval_declared) {
    for (const auto& [triad, increment] : {std::pair{&r.gyro, r.gyro_increment}, {&r.accel, r.accel_increment}})
      for (std::vector<double>& column : *triad)
        for (double& reading : column) reading *= increment ? r.interval_s / clock.interval_s : 1;
    r.interval_s = clock.interval_s;
  }
  if (!r.gyro_increment && !r.accel_increment) r.interval_s = clock.interval_s;
  r.gaps.clear();
  return r;
}

namespace {

constexpr std::size_t longest_gap = 2;  // samples of a gap
constexpr double largest_share = 0.1;   // of the recording

/// The number of samples that are missing before sample i; 0: none, or not a whole number of few.
std::size_t missing_before(const RecordingView& r, std::size_t i) {
  const double intervals = (r.time_s(i) - r.time_s(i - 1)) / r.interval_s, whole = std::round(intervals);
  const bool few = whole >= 2 && whole <= static_cast<double>(longest_gap) + 1 && std::abs(intervals - whole) < 0.25;
  return few ? static_cast<std::size_t>(whole) - 1 : 0;
}

/// Samples to insert before each sample of `gaps`; 0 where the neighbors do not support it.
std::vector<std::size_t> to_fill(const RecordingView& r) {
  std::vector<std::size_t> counts;
  for (const std::size_t i : r.gaps) {
    const bool inside = i >= 2 && i + 1 < r.size();
    const bool alone = inside && r.gaps_in({i - 1, i + 2}) == 1 && r.saturated_in({i - 2, i + 2}) == 0;
    counts.push_back(alone ? missing_before(r, i) : 0);
  }
  return counts;
}

/// Lagrange's weights at x for the nodes -1, 0, m, m + 1.
std::array<double, 4> cubic_weights(double m, double x) {
  const std::array<double, 4> node{-1, 0, m, m + 1};
  std::array<double, 4> weight{};
  for (std::size_t a = 0; a < 4; ++a) {
    weight[a] = 1;
    for (std::size_t b = 0; b < 4; ++b)
      if (a != b) weight[a] *= (x - node[b]) / (node[a] - node[b]);
  }
  return weight;
}

/// A column with the inserted samples.
std::vector<double> filled_column(const std::vector<double>& column, const std::vector<std::size_t>& gaps, const std::vector<std::size_t>& counts) {
  std::vector<double> out;
  std::size_t gap = 0;
  for (std::size_t i = 0; i < column.size(); ++i) {
    if (gap < gaps.size() && gaps[gap] == i) {
      const std::size_t count = counts[gap++];
      for (std::size_t k = 1; k <= count; ++k) out.push_back(filled_sample(std::span(column).subspan(i - 2).first<4>(), count, k));
    }
    out.push_back(column[i]);
  }
  return out;
}

}  // namespace

ShortGaps short_gaps(const RecordingView& recording) {
  ShortGaps out{to_fill(recording), 0};
  for (const std::size_t count : out.counts) out.filled += count;
  if (static_cast<double>(out.filled) > largest_share * static_cast<double>(recording.size())) out.filled = 0;
  return out;
}

double filled_sample(std::span<const double, 4> neighbors, std::size_t count, std::size_t k) {
  const std::array<double, 4> w = cubic_weights(static_cast<double>(count) + 1, static_cast<double>(k));
  return w[0] * neighbors[0] + w[1] * neighbors[1] + w[2] * neighbors[2] + w[3] * neighbors[3];
}

std::int64_t filled_stamp(std::int64_t before_ns, std::int64_t after_ns, std::size_t count, std::size_t k) {
  return before_ns + static_cast<std::int64_t>(k) * ((after_ns - before_ns) / static_cast<std::int64_t>(count + 1));
}

FilledMarks filled_marks(const RecordingView& r, const ShortGaps& inserted) {
  FilledMarks out;
  std::size_t before = 0, limit = 0;
  for (std::size_t gap = 0; gap <= r.gaps.size(); ++gap) {
    const std::size_t next = gap < r.gaps.size() ? r.gaps[gap] : r.size();
    for (; limit < r.saturated.size() && r.saturated[limit] < next; ++limit) out.saturated.push_back(r.saturated[limit] + before);
    if (gap == r.gaps.size()) break;
    before += inserted.counts[gap];
    if (inserted.counts[gap] == 0) out.gaps.push_back(next + before);
  }
  return out;
}

FilledRecording with_short_gaps_filled(Recording recording) {
  FilledRecording out{std::move(recording), 0};
  Recording& r = out.recording;
  const ShortGaps inserted = short_gaps(r);
  out.filled = inserted.filled;
  if (out.filled == 0) return out;
  for (Columns3* triad : {&r.gyro, &r.accel, &r.gyro_temperature, &r.accel_temperature})
    for (std::vector<double>& column : *triad) column = filled_column(column, r.gaps, inserted.counts);
  std::vector<std::int64_t> time_ns;
  time_ns.reserve(r.size() + out.filled);
  std::size_t gap = 0;
  for (std::size_t i = 0; i < r.size(); ++i) {
    if (gap < r.gaps.size() && r.gaps[gap] == i) {
      const std::size_t count = inserted.counts[gap++];
      for (std::size_t k = 1; k <= count; ++k) time_ns.push_back(filled_stamp(r.time_ns[i - 1], r.time_ns[i], count, k));
    }
    time_ns.push_back(r.time_ns[i]);
  }
  FilledMarks marks = filled_marks(r, inserted);
  r.gaps = std::move(marks.gaps), r.saturated = std::move(marks.saturated);
  r.time_ns = std::move(time_ns);
  return out;
}

namespace {

/// Begin of each interval [ns]: the stamp before, or one nominal interval before where that is too far.
std::vector<std::int64_t> interval_begins(const std::vector<std::int64_t>& time_ns, double interval_s) {
  const auto nominal = static_cast<std::int64_t>(std::llround(1e9 * interval_s));
  std::vector<std::int64_t> begins(time_ns.size());
  for (std::size_t i = 0; i < time_ns.size(); ++i) {
    const bool follows = i > 0 && static_cast<double>(time_ns[i] - time_ns[i - 1]) <= 1.5e9 * interval_s;
    begins[i] = follows ? time_ns[i - 1] : time_ns[i] - nominal;
  }
  return begins;
}

}  // namespace

Resampled resample_means(const std::vector<std::int64_t>& time_ns, double source_interval_s, const std::vector<std::vector<double>>& columns,
                         bool increment, const std::vector<std::int64_t>& at, double interval_s) {
  const std::vector<std::int64_t> source_begin = interval_begins(time_ns, source_interval_s), target_begin = interval_begins(at, interval_s);
  Resampled result;
  result.covered.assign(at.size(), 0);
  result.columns.assign(columns.size(), std::vector<double>(at.size(), 0.0));
  constexpr double enough = 0.99;  // of an interval: stamps jitter
  std::size_t first = 0;
  for (std::size_t i = 0; i < at.size(); ++i) {
    while (first < time_ns.size() && time_ns[first] <= target_begin[i]) ++first;
    const double length = static_cast<double>(at[i] - target_begin[i]);
    double overlap_sum = 0;
    for (std::size_t k = first; k < time_ns.size() && source_begin[k] < at[i]; ++k) {
      const double overlap = static_cast<double>(std::min(at[i], time_ns[k]) - std::max(target_begin[i], source_begin[k]));
      if (overlap <= 0) continue;
      overlap_sum += overlap;
      const double weight = overlap / (increment ? static_cast<double>(time_ns[k] - source_begin[k]) : length);
      for (std::size_t c = 0; c < columns.size(); ++c) result.columns[c][i] += weight * columns[c][k];
    }
    result.covered[i] = overlap_sum >= enough * length;
    for (auto& column : result.columns) column[i] *= overlap_sum > 0 ? length / overlap_sum : 0;  // what little is missing is as the rest
  }
  return result;
}

std::vector<std::vector<double>> interpolate(const std::vector<std::int64_t>& time_ns, const std::vector<std::vector<double>>& columns,
                                             const std::vector<std::int64_t>& at) {
  std::vector<std::vector<double>> result(columns.size(), std::vector<double>(at.size()));
  std::size_t after = 0;
  for (std::size_t i = 0; i < at.size(); ++i) {
    while (after < time_ns.size() && time_ns[after] < at[i]) ++after;
    const std::size_t right = std::min(after, time_ns.size() - 1), left = after == 0 ? 0 : after - 1;
    const double part = right == left ? 0 : static_cast<double>(at[i] - time_ns[left]) / static_cast<double>(time_ns[right] - time_ns[left]);
    for (std::size_t c = 0; c < columns.size(); ++c) result[c][i] = columns[c][left] + part * (columns[c][right] - columns[c][left]);
  }
  return result;
}

}  // namespace imulab
