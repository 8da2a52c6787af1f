#include "imulab/recording/stamps.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/stamp_text.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/recording/rounded_stamps.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace imulab {

namespace {

constexpr double interval_tolerance = 0.02;
constexpr std::size_t many = std::size_t{1} << 23;  // stamps: copies of their differences would take 64 MB
constexpr std::size_t rows = 16;                    // stamps that scatter by a fifth of an interval leave a twelfth on the difference of two medians

/// Reorders the differences.
double median_s(std::vector<std::int64_t>& differences) {
  const auto middle = differences.begin() + static_cast<std::ptrdiff_t>(differences.size() / 2);
  std::nth_element(differences.begin(), middle, differences.end());
  if (differences.size() % 2 == 1) return 1e-9 * static_cast<double>(*middle);
  return 0.5e-9 * (static_cast<double>(*middle) + static_cast<double>(*std::max_element(differences.begin(), middle)));
}

/// As of the differences' copy, bit for bit.
StampIntervals intervals_of_many(std::span<const std::int64_t> time_ns) {
  const std::size_t count = time_ns.size() - 1;
  const auto middle = static_cast<double>(difference_of_rank(time_ns, 1, count / 2));
  StampIntervals intervals;
  intervals.median = count % 2 == 1 ? 1e-9 * middle : 0.5e-9 * (middle + static_cast<double>(difference_of_rank(time_ns, 1, count / 2 - 1)));
  double sum = 0, used = 0;
  for (std::size_t i = 1; i < time_ns.size(); ++i)
    if (const auto difference = static_cast<double>(time_ns[i] - time_ns[i - 1]); difference <= 1.5e9 * intervals.median) sum += difference, ++used;
  intervals.mean = 1e-9 * sum / used;
  return intervals;
}

/// The median of what 16 samples take [ns].
double median_length(std::span<const std::int64_t> time_ns) {
  const std::size_t count = time_ns.size() - rows;
  if (time_ns.size() > many) {
    const auto low = static_cast<double>(difference_of_rank(time_ns, rows, (count - 1) / 2));
    return count % 2 == 1 ? low : low + 0.5 * (static_cast<double>(difference_of_rank(time_ns, rows, count / 2)) - low);
  }
  std::vector<double> lengths;
  lengths.reserve(count);
  for (std::size_t i = rows; i < time_ns.size(); ++i) lengths.push_back(static_cast<double>(time_ns[i] - time_ns[i - rows]));
  return median(std::move(lengths));
}

/// Four samples before i and four from i on reveal a single late stamp, also near a gap; sixteen average stamps that all scatter.
bool samples_are_missing(std::span<const std::int64_t> time_ns, std::size_t i, double interval_s) {
  constexpr std::size_t around = 4;
  const auto mean_phase_ns = [&](std::size_t begin, std::size_t end) {
    double sum = 0;
    for (std::size_t k = begin; k < end; ++k)
      sum += static_cast<double>(time_ns[k] - time_ns[i]) - 1e9 * interval_s * (static_cast<double>(k) - static_cast<double>(i));
    return sum / static_cast<double>(end - begin);
  };
  const double later_ns = mean_phase_ns(i, std::min(i + around, time_ns.size())) - mean_phase_ns(i - std::min(i, around), i);
  return later_ns > 0.5e9 * interval_s && clock_step(time_ns, i, interval_s, 0, time_ns.size()) > 0.5;
}

}  // namespace

bool same_interval(double a_s, double b_s) { return std::abs(a_s - b_s) <= interval_tolerance * b_s; }

bool mostly_spaced(std::span<const std::int64_t> time_ns, double interval_s) {
  const auto least_ns = static_cast<std::int64_t>(std::ceil((1 - interval_tolerance) * 1e9 * interval_s));
  const auto most_ns = static_cast<std::int64_t>(std::floor((1 + interval_tolerance) * 1e9 * interval_s));
  std::size_t spaced = 0;
  for (std::size_t i = 1; i < time_ns.size(); ++i) {
    const std::int64_t difference = time_ns[i] - time_ns[i - 1];
    spaced += difference >= least_ns && difference <= most_ns;
  }
  return 2 * spaced + 1 > time_ns.size();
}

void expect_increasing(std::string_view name, std::span<const std::int64_t> time_ns) {
  for (std::size_t i = 1; i < time_ns.size(); ++i)
    if (time_ns[i] <= time_ns[i - 1])
      throw Error(fmt::format("{}: time: sample {} is at {} s, the previous one at {} s; expected stamps that increase", name, i,
                              stamp_text(time_ns[i]), stamp_text(time_ns[i - 1])));
}

std::int64_t difference_of_rank(std::span<const std::int64_t> time_ns, std::size_t apart, std::size_t k) {
  // Digit by digit of 16 bits from the highest on; the sign bit is turned, so that numbers sort as their bits.
  constexpr int digit = 16;
  constexpr std::uint64_t sign = std::uint64_t{1} << 63;
  std::uint64_t known = 0, mask = 0;
  std::vector<std::size_t> counts(std::size_t{1} << digit);
  for (int shift = 64 - digit; shift >= 0; shift -= digit) {
    std::fill(counts.begin(), counts.end(), 0);
    for (std::size_t i = apart; i < time_ns.size(); ++i) {
      const std::uint64_t bits = static_cast<std::uint64_t>(time_ns[i] - time_ns[i - apart]) ^ sign;
      if ((bits & mask) == known) ++counts[(bits >> shift) & (counts.size() - 1)];
    }
    std::size_t value = 0;
    while (value + 1 < counts.size() && k >= counts[value]) k -= counts[value++];
    known |= static_cast<std::uint64_t>(value) << shift;
    mask |= static_cast<std::uint64_t>(counts.size() - 1) << shift;
  }
  return static_cast<std::int64_t>(known ^ sign);
}

StampIntervals stamp_intervals(std::span<const std::int64_t> time_ns, std::span<const std::size_t> without) {
  if (const auto rounded = rounded_stamps(time_ns)) return {rounded->interval_s, rounded->interval_s, rounded->step_s};
  if (time_ns.size() > many && without.empty()) return intervals_of_many(time_ns);
  std::vector<std::int64_t> differences;
  differences.reserve(time_ns.size());
  auto left_out = without.begin();
  for (std::size_t i = 1; i < time_ns.size(); ++i) {
    while (left_out != without.end() && *left_out < i) ++left_out;
    if (left_out == without.end() || *left_out != i) differences.push_back(time_ns[i] - time_ns[i - 1]);
  }
  if (differences.empty()) return {};
  StampIntervals intervals{median_s(differences), 0, std::nullopt};
  double sum = 0, count = 0;
  for (const std::int64_t difference : differences)  // sums of whole numbers: exact in any order
    if (static_cast<double>(difference) <= 1.5e9 * intervals.median) sum += static_cast<double>(difference), ++count;
  intervals.mean = 1e-9 * sum / count;
  return intervals;
}

std::vector<std::size_t> find_gaps(std::span<const std::int64_t> time_ns, double interval_s) {
  const double limit_ns = 1.5e9 * interval_s, clock_s = clock_interval(time_ns, interval_s);
  std::vector<std::size_t> gaps;
  for (std::size_t i = 1; i < time_ns.size(); ++i)
    if (static_cast<double>(time_ns[i] - time_ns[i - 1]) > limit_ns && samples_are_missing(time_ns, i, clock_s)) gaps.push_back(i);
  return gaps;
}

double clock_interval(std::span<const std::int64_t> time_ns, double nominal_s) {
  if (time_ns.size() < 4 * rows) return nominal_s;
  const double interval = 1e-9 * median_length(time_ns) / rows;
  return same_interval(interval, nominal_s) ? interval : nominal_s;  // otherwise samples are lost in every sixteen
}

double clock_step(std::span<const std::int64_t> time_ns, std::size_t i, double interval_s, std::size_t begin, std::size_t end) {
  const auto phase = [&](std::size_t first, std::size_t last) {
    std::vector<double> off;
    for (std::size_t k = first; k < last; ++k)
      off.push_back(1e-9 * static_cast<double>(time_ns[k] - time_ns[i]) / interval_s - (static_cast<double>(k) - static_cast<double>(i)));
    return median(std::move(off));
  };
  return phase(i, std::min(end, i + rows)) - phase(std::max(begin, i - std::min(i, rows)), i);
}

}  // namespace imulab
