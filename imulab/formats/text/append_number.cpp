#include "imulab/formats/text/append_number.hpp"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <optional>

namespace imulab::text {
namespace {

constexpr std::array scales{1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15};

/// A magnitude times the scale, rounded as the exact product is; empty where that is too large or too close to a half.
std::optional<std::uint64_t> rounded_product(double magnitude, double scale) {
  constexpr double integers = 9007199254740992;  // 2^53: all below are doubles
  const double product = magnitude * scale;
  if (!(product < integers)) return std::nullopt;
  const double left_out = std::fma(magnitude, scale, -product), whole = std::nearbyint(product), rest = (product - whole) + left_out;
  if (std::abs(std::abs(rest) - 0.5) < 1e-6) return std::nullopt;
  return static_cast<std::uint64_t>(whole) + (rest > 0.5) - (rest < -0.5);
}

/// An integer with a point before its last digits.
void append_digits(std::string& to, std::uint64_t digits, int decimals) {
  const auto scale = static_cast<std::uint64_t>(scales[static_cast<std::size_t>(decimals)]);
  std::array<char, 24> text;
  char* const last = text.data() + text.size();
  char* end = std::to_chars(text.data(), last, digits / scale).ptr;
  if (decimals > 0) {
    char* const point = end;
    end = std::to_chars(point, last, scale + digits % scale).ptr;  // with a 1 before all of its zeros
    *point = '.';
  }
  to.append(text.data(), static_cast<std::size_t>(end - text.data()));
}

}  // namespace

void append_fixed(std::string& to, double value, int decimals) {
  const auto digits = rounded_product(std::abs(value), scales[static_cast<std::size_t>(decimals)]);
  if (!digits) {
    fmt::format_to(std::back_inserter(to), "{:.{}f}", value, decimals);
    return;
  }
  if (std::signbit(value)) to += '-';
  append_digits(to, *digits, decimals);
}

void append_four_digits(std::string& to, double value) {
  constexpr double least = 1e-4, most = 9999;  // beyond them with an exponent
  const double magnitude = std::abs(value);
  int decimals = 7;
  while (decimals > 0 && magnitude >= scales[static_cast<std::size_t>(8 - decimals)] * least) --decimals;
  const auto digits = magnitude >= least && magnitude < most ? rounded_product(magnitude, scales[static_cast<std::size_t>(decimals)]) : std::nullopt;
  if (!digits) {
    fmt::format_to(std::back_inserter(to), "{:.4g}", value);
    return;
  }
  if (std::signbit(value)) to += '-';
  append_digits(to, *digits, decimals);
  if (decimals == 0) return;
  while (to.back() == '0') to.pop_back();
  if (to.back() == '.') to.pop_back();
}

}  // namespace imulab::text
