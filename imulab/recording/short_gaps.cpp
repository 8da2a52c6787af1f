#include "imulab/recording/short_gaps.hpp"

#include <array>
#include <cmath>
#include <utility>

namespace imulab {

namespace {

constexpr std::size_t longest = 2;     // samples of a gap
constexpr double largest_share = 0.1;  // of the recording

/// How many samples are missing before sample i; 0: none, or not a whole number of few.
std::size_t missing_before(const RecordingView& r, std::size_t i) {
  const double intervals = (r.time_s(i) - r.time_s(i - 1)) / r.interval_s, whole = std::round(intervals);
  const bool few = whole >= 2 && whole <= static_cast<double>(longest) + 1 && std::abs(intervals - whole) < 0.25;
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

}  // namespace imulab
