// Decimal text <-> 64-bit nanoseconds, exactly: without floating point in between.
#pragma once

#include <cstdint>
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
/// The same into `out`, which has room for 24 characters; returns the end.
char* write_seconds(char* out, std::int64_t ns);

}  // namespace imulab::text
