#include "imulab/recording/clock.hpp"

#include "imulab/core/error.hpp"
#include "imulab/recording/unit_names.hpp"

#include <cmath>
#include <limits>

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

}  // namespace imulab
