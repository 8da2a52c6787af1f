// Decimal text <-> 64-bit nanoseconds, exactly: without floating point in between.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace imulab::text {

/// For std::from_chars, which takes no + in front. One before another sign stays: "+-5" is no number.
inline std::string_view without_plus(std::string_view number) {
  if (number.starts_with('+') && !number.starts_with("+-")) number.remove_prefix(1);
  return number;
}

struct ScaledInteger {
  enum class Status { good, not_a_number, too_large };
  Status status = Status::not_a_number;
  std::int64_t value = 0;
  const char* end = nullptr;  ///< of the number's text
};

/// Reads the decimal number (1700000000.123456789, 1.7e9, -5) at `first`, multiplied by 10^exponent, as an integer; fractions round to the nearest, a
/// half away from zero. Throws nothing: the status says what is wrong.
ScaledInteger scaled_integer(const char* first, const char* last, int exponent);

/// Nanoseconds as seconds with as many decimals as they need: 1.000000001, -0.5, 3.
std::string seconds_text(std::int64_t ns);
/// Writes this text into `out`, which has room for 24 characters; returns the end.
char* write_seconds(char* out, std::int64_t ns);

}  // namespace imulab::text

namespace imulab {

// Dates and times of day, UTC. Times are seconds since 1970.

/// "2026-03-31T12:00:00Z"; empty beyond the year 9999.
std::string time_text(double time);
/// The date of a stamp [s] as seconds since 1970, in UTC to the millisecond ("2023-11-14T22:13:20.010Z"); empty where that is not from 2000 to 2099:
/// such a clock counts from something else.
std::string date_text(double stamp);
/// The time of a text that time_of knows; throws Error for any other.
double parse_time(const std::string& text);

}  // namespace imulab
