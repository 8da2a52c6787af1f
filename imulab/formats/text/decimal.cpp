#include "imulab/formats/text/decimal.hpp"

#include "imulab/core/stamp_text.hpp"
#include "imulab/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <limits>

namespace imulab::text {
namespace {

constexpr std::array<std::uint64_t, 20> power_of_ten = [] {
  std::array<std::uint64_t, 20> p{1};
  for (std::size_t i = 1; i < p.size(); ++i) p[i] = 10 * p[i - 1];
  return p;
}();

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// The digits of a number: 19 of them, the first one dropped, and the power of ten of the last one kept.
struct Digits {
  std::uint64_t value = 0;
  int dropped = -1;
  int exponent = 0;
  bool any = false;
};

const char* read_digits(const char* p, const char* last, Digits& d) {
  constexpr std::uint64_t full = 1'000'000'000'000'000'000;  // from here on 19 digits are held, and a 20th might not fit
  bool fraction = false;
  for (; p < last; ++p) {
    if (is_digit(*p)) {
      d.any = true;
      if (d.value < full) {
        d.value = 10 * d.value + static_cast<std::uint64_t>(*p - '0');
        d.exponent -= fraction;
      } else {
        if (d.dropped < 0) d.dropped = *p - '0';
        d.exponent += !fraction;
      }
    } else if (*p == '.' && !fraction) {
      fraction = true;
    } else {
      break;
    }
  }
  return p;
}

/// d.value x 10^d.exponent as an integer; false where it does not fit. Digits dropped weigh less than the last one kept: they decide the
/// rounding where that is the unit, and nothing above it.
bool scale(const Digits& d, std::uint64_t& result) {
  result = d.value;
  if (d.value == 0) return true;
  if (d.exponent > 18) return false;
  if (d.exponent > 0) return !__builtin_mul_overflow(d.value, power_of_ten[static_cast<std::size_t>(d.exponent)], &result);
  if (d.exponent == 0) {
    result += d.dropped >= 5;
    return true;
  }
  if (d.exponent < -19) {
    result = 0;
    return true;
  }
  const std::uint64_t divisor = power_of_ten[static_cast<std::size_t>(-d.exponent)];
  result = d.value / divisor + (d.value % divisor >= divisor / 2);
  return true;
}

}  // namespace

ScaledInteger scaled_integer(const char* first, const char* last, int exponent) {
  ScaledInteger result;
  const char* p = first;
  const bool negative = p < last && *p == '-';
  if (p < last && (*p == '-' || *p == '+')) ++p;
  Digits digits;
  digits.exponent = exponent;
  p = read_digits(p, last, digits);
  if (!digits.any) return result;
  if (p < last && (*p == 'e' || *p == 'E')) {
    const char* q = p + 1;
    if (q + 1 < last && *q == '+' && is_digit(q[1])) ++q;
    int power = 0;
    const auto [end, error] = std::from_chars(q, last, power);
    if (error == std::errc::invalid_argument) return result;
    if (error == std::errc::result_out_of_range) power = *q == '-' ? -10'000 : 10'000;
    digits.exponent += std::clamp(power, -10'000, 10'000);
    p = end;
  }
  result.end = p;
  std::uint64_t magnitude = 0;
  if (!scale(digits, magnitude) || magnitude > static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max())) {
    result.status = ScaledInteger::Status::too_large;
    return result;
  }
  result.status = ScaledInteger::Status::good;
  result.value = negative ? -static_cast<std::int64_t>(magnitude) : static_cast<std::int64_t>(magnitude);
  return result;
}

char* write_seconds(char* out, std::int64_t ns) {
  constexpr std::uint64_t second = 1'000'000'000;
  if (ns < 0) *out++ = '-';
  const std::uint64_t magnitude = ns < 0 ? 0 - static_cast<std::uint64_t>(ns) : static_cast<std::uint64_t>(ns);
  out = std::to_chars(out, out + 12, magnitude / second).ptr;
  std::uint64_t fraction = magnitude % second;
  if (fraction == 0) return out;
  *out++ = '.';
  for (std::uint64_t weight = second / 10; fraction != 0; fraction %= weight, weight /= 10) *out++ = static_cast<char>('0' + fraction / weight);
  return out;
}

std::string seconds_text(std::int64_t ns) {
  std::array<char, 24> text;
  return {text.data(), write_seconds(text.data(), ns)};
}

}  // namespace imulab::text

namespace imulab {

std::string time_text(double time) {
  constexpr double latest = 253402300799.0;  // of the year 9999
  if (!(time > -latest && time <= latest)) return "";
  const auto seconds = static_cast<std::time_t>(std::floor(time));
  std::tm parts{};
  std::array<char, 32> text;
  gmtime_r(&seconds, &parts);
  return {text.data(), std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &parts)};
}

std::string date_text(double stamp) {
  constexpr double year_2000 = 946684800, year_2100 = 4102444800;
  if (!(stamp >= year_2000 && stamp < year_2100)) return {};
  const double ms = std::round(1e3 * stamp), seconds = std::floor(1e-3 * ms), fraction = ms - 1e3 * seconds;
  std::string text = time_text(seconds);
  if (fraction > 0) text.insert(text.size() - 1, fmt::format(".{:03.0f}", fraction));
  return text;
}

double parse_time(const std::string& text) {
  if (const std::optional<double> time = time_of(text)) return *time;
  throw Error(fmt::format("{}: is no time; expected UTC as in 2026-03-31 or 2026-03-31T12:00:00Z", text));
}

}  // namespace imulab
