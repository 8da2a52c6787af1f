#include "imulab/recording/repeated_rows.hpp"

#include "imulab/recording/clock.hpp"
#include "imulab/recording/resampling.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <span>
#include <utility>

namespace imulab {
namespace {

constexpr std::size_t block_rows = 128;
constexpr double least_share = 0.002;    // of a logger's repeats
constexpr double rounding = 1e-6;        // of a reading: below any noise; the readings of a simulation without noise hardly change
constexpr std::size_t long_streak = 64;  // of rows: an IMU without noise reads the same throughout a rest

/// How many readings of each sample equal those of the sample before; a NaN, and the first sample, equal none.
std::vector<unsigned char> equal_readings(const RecordingView& recording, std::size_t first, std::size_t end) {
  std::vector<unsigned char> equal(recording.size(), 0);
  for (std::size_t column = first; column < end; ++column) {
    double before = std::nan("");
    std::size_t i = 0;
    for_each_block(recording, column, {0, recording.size()}, usual_block, [&](std::span<const double> samples) {
      for (const double sample : samples) equal[i++] += std::abs(sample - before) <= rounding * std::abs(before), before = sample;
    });
  }
  return equal;
}

/// Samples of a block by how many of their readings repeat: all; all but one or two; the rest.
struct BlockCounts {
  std::size_t rows = 0, all = 0, nearly = 0;

  /// Where readings change, all axes change together: what repeats as a whole does not do so by chance.
  bool is_fine() const { return 5 * nearly <= rows - all && 20 * (rows - all) >= rows; }
};

/// Marks long streaks as changes of their own: they count in no block.
std::vector<char> in_long_streak(const std::vector<unsigned char>& equal, unsigned char axes) {
  std::vector<char> marks(equal.size(), 0);
  for (std::size_t i = 0; i < equal.size();) {
    std::size_t end = i;
    while (end < equal.size() && equal[end] == axes) ++end;
    if (end - i >= long_streak) std::fill(marks.begin() + static_cast<std::ptrdiff_t>(i), marks.begin() + static_cast<std::ptrdiff_t>(end), 1);
    i = end + 1;
  }
  return marks;
}

std::vector<BlockCounts> blocks_of(const std::vector<unsigned char>& equal, const std::vector<char>& skipped, unsigned char axes) {
  std::vector<BlockCounts> blocks(equal.size() / block_rows + 1);
  for (std::size_t i = 1; i < equal.size(); ++i) {
    if (skipped[i]) continue;
    BlockCounts& block = blocks[i / block_rows];
    ++block.rows;
    block.all += equal[i] == axes;
    block.nearly += equal[i] + 2 >= axes && equal[i] < axes;
  }
  return blocks;
}

/// Of coarse readings: the samples that repeat beyond chance, at least. With K independent axes, whatever their chances, n(K) is at most
/// n(K-1)^2 / n(K-2) (K-1) / (2K) (Newton's inequality). That holds while the chances are the same throughout; they are not where an IMU rests and
/// moves: then nothing is said.
double beyond_chance(const std::vector<unsigned char>& equal, const std::vector<char>& skipped, const std::vector<BlockCounts>& blocks,
                     unsigned char axes) {
  std::array<double, 3> n{};  // with all, all but one, all but two
  double rows = 0;
  for (std::size_t i = 1; i < equal.size(); ++i) {
    if (skipped[i]) continue;
    ++rows;
    if (equal[i] + 2 >= axes) ++n[static_cast<std::size_t>(axes - equal[i])];
  }
  const double usual = (n[1] + n[2]) / std::max(rows, 1.0), K = axes;
  std::size_t unusual = 0, whole = 0;
  for (const BlockCounts& block : blocks) {
    if (block.rows < block_rows) continue;
    const double share = static_cast<double>(block.nearly) / block_rows;
    ++whole, unusual += std::abs(share - usual) > 6 * std::sqrt(usual / block_rows);
  }
  if (n[2] < 50 || 50 * unusual > whole) return 0;
  const double chance = n[1] * n[1] / n[2] * (K - 1) / (2 * K), scatter = std::sqrt(n[0]) + chance * std::sqrt(4 / n[1] + 1 / n[2]);
  return n[0] - chance > 6 * scatter ? n[0] - chance : 0;
}

/// A slow sensor repeats every so many samples, a logger that misses some at random: in windows with twenty repeats each the count scatters by less
/// than one, or by about four.
bool come_evenly(const std::vector<std::size_t>& samples, std::size_t rows) {
  const std::size_t window = 20 * rows / samples.size();
  std::vector<double> counts(rows / window, 0);
  for (const std::size_t i : samples)
    if (i / window < counts.size()) ++counts[i / window];
  if (counts.size() < 3) return false;
  const double n = static_cast<double>(counts.size()), mean = std::accumulate(counts.begin(), counts.end(), 0.0) / n;
  double square = 0;
  for (const double count : counts) square += std::pow(count - mean, 2);
  return square / (n - 1) < 2;
}

template <class T>
void erase_samples(std::vector<T>& column, const std::vector<std::size_t>& samples) {
  if (column.empty()) return;
  std::size_t to = samples.front(), next = 0;
  for (std::size_t i = to; i < column.size(); ++i) {
    if (next < samples.size() && samples[next] == i)
      ++next;
    else
      column[to++] = column[i];
  }
  column.resize(to);
}

}  // namespace

std::optional<RepeatedRows> repeated_rows(const RecordingView& recording, std::size_t first, std::size_t end) {
  if (recording.size() < 4 * block_rows) return std::nullopt;
  const auto axes = static_cast<unsigned char>(end - first);
  const std::vector<unsigned char> equal = equal_readings(recording, first, end);
  const std::vector<char> skipped = in_long_streak(equal, axes);
  const std::vector<BlockCounts> blocks = blocks_of(equal, skipped, axes);
  const auto n = static_cast<double>(recording.size());
  std::size_t fine = 0, coarse = 0;
  for (const BlockCounts& block : blocks) (block.is_fine() ? fine : coarse) += block.all;
  RepeatedRows out;
  if (fine > 4 * coarse && fine >= 10 && static_cast<double>(fine) > least_share * n) {
    for (std::size_t i = 1; i < equal.size(); ++i)
      if (equal[i] == axes && !skipped[i] && blocks[i / block_rows].is_fine()) out.samples.push_back(i);
    out.share = static_cast<double>(out.samples.size()) / n;
    out.evenly = come_evenly(out.samples, recording.size());
    return out;
  }
  const double beyond = beyond_chance(equal, skipped, blocks, axes);
  if (!(beyond > 10 * least_share * n)) return std::nullopt;
  out.share = beyond / n;
  out.some_by_chance = true;
  return out;
}

Recording without_samples(Recording r, const RepeatedRows& repeated) {
  const std::vector<std::size_t>& samples = repeated.samples;
  if (samples.empty()) return r;
  erase_samples(r.time_ns, samples);
  for (Columns3* triad : {&r.gyro, &r.accel, &r.gyro_temperature, &r.accel_temperature})
    for (std::vector<double>& column : *triad) erase_samples(column, samples);
  std::vector<std::size_t> saturated;
  for (const std::size_t i : r.saturated) {
    const auto before = std::lower_bound(samples.begin(), samples.end(), i);
    if (before == samples.end() || *before != i) saturated.push_back(i - static_cast<std::size_t>(before - samples.begin()));
  }
  r.saturated = std::move(saturated);
  if (repeated.evenly)
    if (const std::optional<EvenClock> clock = even_clock(r.time_ns))
      for (std::size_t i = 0; i < r.size(); ++i) r.time_ns[i] = clock->stamp_ns(i);
  return r;
}

std::string said_of(const RepeatedRows& repeated, std::string_view of, bool left_out) {
  const std::string what = fmt::format("{:.3g} % of the {} repeat the readings of the row before at a new stamp", 100 * repeated.share, of);
  if (repeated.some_by_chance)
    return what +
           " beyond what their coarse resolution explains; which ones cannot be told, so they are kept: noise is then wrong by some percent to "
           "tens of percent; expected a log of new readings alone";
  const char* const why = repeated.evenly ? "the sensor is slower than the log" : "the logger missed readings";
  if (!left_out) return fmt::format("{}: {}; they are kept; noise and turns that change within them come out wrong", what, why);
  return fmt::format("{}: {}; they were left out", what, why);
}

}  // namespace imulab
