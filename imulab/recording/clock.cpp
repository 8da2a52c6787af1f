#include "imulab/recording/clock.hpp"

#include "imulab/core/stamp_text.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/error.hpp"
#include "imulab/recording/unit_names.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace imulab {
namespace {

constexpr std::int64_t farthest = std::numeric_limits<std::int64_t>::max() / 2;

/// `count` over `per_second`, in whole nanoseconds; nothing beyond the farthest. A double has too few digits for counts since 1970, and a long double
/// has more on some processors alone: whole seconds and their remainder, which a fused product leaves exact, are both known to the nanosecond.
std::optional<std::int64_t> nanoseconds_at(std::int64_t count, double per_second) {
  if (count < -farthest || count > farthest) return std::nullopt;
  const auto high = static_cast<double>(count);
  const double seconds = std::trunc(high / per_second);
  if (!(1e9 * (std::abs(seconds) + 1) < static_cast<double>(farthest))) return std::nullopt;
  const auto low = static_cast<double>(count - static_cast<std::int64_t>(high));
  const double rest = std::fma(-seconds, per_second, high) + low;
  return 1'000'000'000 * static_cast<std::int64_t>(seconds) + std::llround(1e9 * rest / per_second);
}

}  // namespace

Clock::Clock(const TimeSource& source, std::optional<double> rate_hz) : zero_(source.zero) {
  const bool counts = !source.column || source.unit == "sample" || source.unit == "tick";
  if (counts) {
    per_second_ = source.column && source.unit == "tick" ? source.ticks_per_s : rate_hz;
    if (!per_second_) throw Error("the recording has no stamps in seconds; expected the rate");
  }
  exponent_ = counts ? 0 : time_exponent(source.unit);
  fraction_exponent_ = time_exponent(source.fraction_unit);
  if (source.wrap_bits) {
    modulus_ = std::int64_t{1} << *source.wrap_bits;
    for (int i = 0; i < exponent_; ++i) modulus_ *= 10;  // 2^32 s is 4.3e18 ns: it fits
  }
}

std::optional<std::int64_t> Clock::next(std::int64_t stamp, std::int64_t fraction_ns) {
  if (modulus_ > 0) {
    if (last_ && stamp < *last_ - modulus_ / 2 && __builtin_add_overflow(wrapped_, modulus_, &wrapped_)) return std::nullopt;
    last_ = stamp;
  }
  std::int64_t time = 0;
  if (__builtin_add_overflow(stamp, wrapped_, &time) || __builtin_add_overflow(time, fraction_ns, &time) ||
      __builtin_sub_overflow(time, zero_, &time))
    return std::nullopt;
  if (!per_second_) return time < -farthest || time > farthest ? std::nullopt : std::optional(time);
  return nanoseconds_at(time, *per_second_);
}

std::optional<std::int64_t> scaled_stamp(double number, int exponent) {
  constexpr double largest = 9e18;  // below 2^63
  const double value = number * std::pow(10.0, exponent);
  if (!(std::abs(value) < largest)) return std::nullopt;
  return std::llround(value);
}

std::optional<std::int64_t> scaled_stamp(std::int64_t number, int exponent) {
  for (int i = 0; i < exponent; ++i)
    if (__builtin_mul_overflow(number, 10, &number)) return std::nullopt;
  return number;
}

namespace {

constexpr double interval_tolerance = 0.02;
constexpr std::size_t many = std::size_t{1} << 23;  // stamps: copies of their differences would take 64 MB
constexpr std::size_t averaged = 16;                // stamps that scatter by a fifth of an interval leave a twelfth on the difference of two medians

/// Calls with each difference of stamps `apart` samples apart, without those that end at a sample in `without`.
template <class Each>
void for_each_difference(std::span<const std::int64_t> time_ns, std::size_t apart, std::span<const std::size_t> without, const Each& each) {
  auto left_out = without.begin();
  for (std::size_t i = apart; i < time_ns.size(); ++i) {
    while (left_out != without.end() && *left_out < i) ++left_out;
    if (left_out == without.end() || *left_out != i) each(static_cast<double>(time_ns[i] - time_ns[i - apart]));
  }
}

/// The median of these differences [ns]; nothing where there is none.
std::optional<double> median_difference(std::span<const std::int64_t> time_ns, std::size_t apart, std::span<const std::size_t> without) {
  if (time_ns.size() > many && without.empty()) {
    const std::size_t count = time_ns.size() - apart;
    const auto low = static_cast<double>(difference_of_rank(time_ns, apart, (count - 1) / 2));
    return count % 2 == 1 ? low : low + 0.5 * (static_cast<double>(difference_of_rank(time_ns, apart, count / 2)) - low);
  }
  std::vector<double> differences;
  differences.reserve(time_ns.size());
  for_each_difference(time_ns, apart, without, [&](double difference) { differences.push_back(difference); });
  return differences.empty() ? std::nullopt : std::optional(median(std::move(differences)));
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
  const std::optional<double> middle_ns = median_difference(time_ns, 1, without);
  if (!middle_ns) return {};
  StampIntervals intervals{1e-9 * *middle_ns, 0, std::nullopt};
  double sum = 0, count = 0;  // of whole numbers: exact in any order
  for_each_difference(time_ns, 1, without, [&](double difference) {
    if (difference <= 1.5e9 * intervals.median) sum += difference, ++count;
  });
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
  if (time_ns.size() < 4 * averaged) return nominal_s;
  const double interval = 1e-9 * *median_difference(time_ns, averaged, {}) / averaged;
  return same_interval(interval, nominal_s) ? interval : nominal_s;  // otherwise samples are lost in every sixteen
}

double clock_step(std::span<const std::int64_t> time_ns, std::size_t i, double interval_s, std::size_t begin, std::size_t end) {
  const auto phase = [&](std::size_t first, std::size_t last) {
    std::vector<double> off;
    for (std::size_t k = first; k < last; ++k)
      off.push_back(1e-9 * static_cast<double>(time_ns[k] - time_ns[i]) / interval_s - (static_cast<double>(k) - static_cast<double>(i)));
    return median(std::move(off));
  };
  return phase(i, std::min(end, i + averaged)) - phase(std::max(begin, i - std::min(i, averaged)), i);
}

namespace {

constexpr std::size_t near = 16, far = 1024;  // samples
constexpr double nearly_all = 0.9;            // of the stamps: the others are near lost samples

/// The middle one of the differences of stamps that far apart [ns].
double middle_difference(std::span<const std::int64_t> time_ns, std::size_t apart) {
  return static_cast<double>(difference_of_rank(time_ns, apart, (time_ns.size() - apart) / 2));
}

/// The largest number that all differences are multiples of [ns]; 0 where it is less than a thousandth of `usual`: what is rounded so finely moves no
/// result.
std::int64_t common_step(std::span<const std::int64_t> time_ns, std::int64_t usual) {
  std::int64_t step = usual;
  for (std::size_t i = 1; i < time_ns.size() && 1000 * step >= usual; ++i) step = std::gcd(step, time_ns[i] - time_ns[i - 1]);
  return 1000 * step >= usual ? step : 0;
}

/// True if stamps that many samples apart differ as an even clock's do, give or take the rounding of both.
bool is_even(std::span<const std::int64_t> time_ns, std::size_t apart, double interval_ns, double rounding_ns) {
  std::size_t even = 0;
  for (std::size_t i = apart; i < time_ns.size(); ++i)
    even += std::abs(static_cast<double>(time_ns[i] - time_ns[i - apart]) - static_cast<double>(apart) * interval_ns) <= rounding_ns;
  return static_cast<double>(even) >= nearly_all * static_cast<double>(time_ns.size() - apart);
}

/// The mean interval in the stretches without a lost sample.
double mean_interval(std::span<const std::int64_t> time_ns, double interval_ns) {
  double time = 0, intervals = 0;
  std::size_t begin = 0;
  const auto add = [&](std::size_t end) {  // of short ones the rounding would count
    if (end - begin > near) time += static_cast<double>(time_ns[end - 1] - time_ns[begin]), intervals += static_cast<double>(end - 1 - begin);
    begin = end;
  };
  for (const std::size_t gap : find_gaps(time_ns, 1e-9 * interval_ns)) add(gap);
  add(time_ns.size());
  return intervals > 0 ? time / intervals : interval_ns;
}

}  // namespace

std::optional<RoundedStamps> rounded_stamps(std::span<const std::int64_t> time_ns) {
  if (time_ns.size() < 4 * near) return std::nullopt;
  const std::int64_t usual = difference_of_rank(time_ns, 1, time_ns.size() / 2), step = common_step(time_ns, usual);
  if (step == 0) return std::nullopt;
  const auto rounding = static_cast<double>(step);
  double interval = middle_difference(time_ns, near) / static_cast<double>(near);
  if (step == usual && interval < 1.1 * rounding) return std::nullopt;  // the clock itself advances by whole steps, of which a few are lost
  if (!is_even(time_ns, 1, interval, rounding) || !is_even(time_ns, near, interval, 2 * rounding)) return std::nullopt;
  // The rounding of two stamps is a sixteenth of it in the interval over sixteen samples, and less over more, as long as few windows lost one.
  std::size_t apart = near;
  for (; 16 * apart <= time_ns.size() && apart < far; apart *= 4) {
    const double longer = middle_difference(time_ns, 4 * apart) / static_cast<double>(4 * apart);
    if (!is_even(time_ns, 4 * apart, longer, 2 * rounding)) break;
    interval = longer;
  }
  return RoundedStamps{1e-9 * rounding, 1e-9 * mean_interval(time_ns, interval)};
}

namespace {

struct Early {
  double index, late_ns;
};

/// The earliest stamp of each block, less the even clock of the whole.
std::vector<Early> earliest(std::span<const std::int64_t> time_ns, std::size_t block, double interval_ns) {
  std::vector<Early> out;
  for (std::size_t begin = 0; begin + block <= time_ns.size(); begin += block) {
    Early best{0, HUGE_VAL};
    for (std::size_t i = begin; i < begin + block; ++i) {
      const double late = static_cast<double>(time_ns[i] - time_ns[0]) - interval_ns * static_cast<double>(i);
      if (late < best.late_ns) best = {static_cast<double>(i), late};
    }
    out.push_back(best);
  }
  return out;
}

/// Straight line by least squares: late = a + b index.
std::array<double, 2> line_through(const std::vector<Early>& points) {
  double n = static_cast<double>(points.size()), mean_i = 0, mean_l = 0, si = 0, sl = 0;
  for (const Early& p : points) mean_i += p.index / n, mean_l += p.late_ns / n;
  for (const Early& p : points) si += (p.index - mean_i) * (p.index - mean_i), sl += (p.index - mean_i) * (p.late_ns - mean_l);
  const double slope = si > 0 ? sl / si : 0;
  return {mean_l - slope * mean_i, slope};
}

}  // namespace

std::string even_rows_advice(std::optional<double> rate_hz) {
  const std::string rate = rate_hz ? fmt::format("{:.4g}", *rate_hz) : "HZ";
  return fmt::format(
      "where the sensor samples evenly, take its rows at equal spacing: --time none --rate {0}; in a session time = {{ unit = \"sample\" "
      "}} and rate_hz = {0}",
      rate);
}

std::int64_t EvenClock::stamp_ns(std::size_t i) const { return std::llround(first_ns + 1e9 * interval_s * static_cast<double>(i)); }

std::optional<EvenClock> even_clock(std::span<const std::int64_t> time_ns) {
  constexpr std::size_t fewest = 200, block = 50;
  if (time_ns.size() < fewest) return std::nullopt;
  const double mean_ns = static_cast<double>(time_ns.back() - time_ns.front()) / static_cast<double>(time_ns.size() - 1);
  const std::vector<Early> early = earliest(time_ns, block, mean_ns);
  const auto [late, slope] = line_through(early);
  const double interval_ns = mean_ns + slope;
  for (const Early& p : early)
    if (!(std::abs(p.late_ns - late - slope * p.index) < 0.25 * interval_ns)) return std::nullopt;
  EvenClock clock{static_cast<double>(time_ns[0]) + late, 1e-9 * interval_ns, 0};
  double square = 0;
  for (std::size_t i = 0; i < time_ns.size(); ++i) square += std::pow(static_cast<double>(time_ns[i] - clock.stamp_ns(i)), 2);
  clock.scatter_s = 1e-9 * std::sqrt(square / static_cast<double>(time_ns.size()));
  return clock;
}

}  // namespace imulab
