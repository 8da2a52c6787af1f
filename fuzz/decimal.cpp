// Text as a number: the reader of stamps against arithmetic on the digits themselves, the readers of readings against the C library.
#include "imulab/formats/text/decimal.hpp"

#include "imulab/error.hpp"
#include "imulab/formats/recording/text/csv.hpp"

#include "fuzz/fuzzed_file.hpp"
#include "fuzz/targets.hpp"
#include <algorithm>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string>

namespace imulab::fuzz {

namespace {

using text::ScaledInteger;

bool digit(char c) { return c >= '0' && c <= '9'; }

struct Written {
  ScaledInteger::Status status = ScaledInteger::Status::not_a_number;
  std::string integer;  ///< its digits, without zeros in front; "-" in front
  std::size_t end = 0;
};

/// The number at the begin of a text times 10^exponent, rounded to an integer: all on digits as text, of any length.
Written by_hand(std::string_view text, int exponent) {
  Written out;
  std::size_t at = 0;
  const bool negative = text.starts_with('-');
  if (negative || text.starts_with('+')) ++at;
  std::string digits;
  long place = exponent;  // of the last digit
  bool fraction = false;
  for (; at < text.size() && (digit(text[at]) || (text[at] == '.' && !fraction)); ++at) {
    if (text[at] == '.')
      fraction = true;
    else
      digits += text[at], place -= fraction;
  }
  if (digits.empty()) return out;
  if (at < text.size() && (text[at] == 'e' || text[at] == 'E')) {
    const bool sign = at + 1 < text.size() && (text[at + 1] == '-' || text[at + 1] == '+');
    std::size_t end = at + 1 + sign;
    std::string power;
    for (; end < text.size() && digit(text[end]); ++end) power += text[end];
    if (power.empty()) return out;
    power.erase(0, std::min(power.find_first_not_of('0'), power.size()));
    const long size = power.empty() ? 0 : power.size() > 5 ? 99'999 : std::stol(power);
    place += text[at + 1] == '-' ? -size : size;
    at = end;
  }
  out.end = at;
  digits.erase(0, std::min(digits.find_first_not_of('0'), digits.size()));
  const long whole = digits.empty() ? 0 : static_cast<long>(digits.size()) + place;  // digits before the point
  out.status = whole > 19 ? ScaledInteger::Status::too_large : ScaledInteger::Status::good;
  if (whole > 19) return out;
  unsigned long long value = 0;
  for (long k = 0; k < whole; ++k)
    value = 10 * value + static_cast<unsigned long long>(k < static_cast<long>(digits.size()) ? digits[static_cast<std::size_t>(k)] - '0' : 0);
  if (whole >= 0 && whole < static_cast<long>(digits.size()) && digits[static_cast<std::size_t>(whole)] >= '5') ++value;
  if (value > 9'223'372'036'854'775'807ULL) out.status = ScaledInteger::Status::too_large;
  out.integer = (negative && value != 0 ? "-" : "") + std::to_string(value);
  return out;
}

void expect_exact(std::string_view number, int exponent) {
  const ScaledInteger read = text::scaled_integer(number.data(), number.data() + number.size(), exponent);
  const Written exact = by_hand(number, exponent);
  if (read.status != exact.status) finding("a stamp is a number to one and none to the other");
  if (read.status == ScaledInteger::Status::not_a_number) return;
  if (read.end != number.data() + exact.end) finding("a stamp ends at another place");
  if (read.status == ScaledInteger::Status::good && std::to_string(read.value) != exact.integer) finding("a stamp is not exact");
}

/// Two equal fields in a row between others.
void expect_as_c_library(const std::string& number) {
  errno = 0;
  char* end = nullptr;
  const double exact = std::strtod(number.c_str(), &end);
  const bool whole = !number.empty() && *end == '\0' && std::isfinite(exact) && !(errno == ERANGE && exact == 0);  // smaller than any is an error
  const FuzzedFile file("a,b\n0,0\n" + number + "," + number + "\n0,0\n");
  try {
    const recording_io::TableRows table = recording_io::read_csv(file.path(), {.column = std::nullopt}, 100, {std::string("b")});
    if (!whole) finding("a reading that the C library refuses");
    if (std::bit_cast<std::uint64_t>(table.columns[0].numbers[1]) != std::bit_cast<std::uint64_t>(exact))
      finding("a reading is not the nearest double");
  } catch (const Error&) {
    if (whole) finding("a reading is refused that the C library reads");
  }
}

}  // namespace

void decimal(std::string_view bytes) {
  constexpr std::size_t longest = 4000;
  if (bytes.empty() || bytes.size() > longest) return;
  const int exponent = static_cast<unsigned char>(bytes[0]) % 10;  // of "s", 9, down to "ns", 0
  const std::string_view number = bytes.substr(1);
  expect_exact(number, exponent);
  if (std::all_of(number.begin(), number.end(), [](char c) { return digit(c) || std::string_view("+-.eE").find(c) != std::string_view::npos; }))
    expect_as_c_library(std::string(number));
  if (number.size() < sizeof(std::int64_t)) return;
  std::int64_t ns = 0;
  std::copy_n(number.data(), sizeof ns, reinterpret_cast<char*>(&ns));
  const std::string written = text::seconds_text(ns);
  const ScaledInteger again = text::scaled_integer(written.data(), written.data() + written.size(), 9);
  const bool lowest = ns == INT64_MIN;  // has no positive counterpart: too large to be read
  if (!lowest && (again.status != ScaledInteger::Status::good || again.value != ns)) finding("a time reads back as another");
}

}  // namespace imulab::fuzz
