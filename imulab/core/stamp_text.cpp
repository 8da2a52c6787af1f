#include "imulab/core/stamp_text.hpp"

#include <fmt/format.h>

#include <cmath>

namespace imulab {

namespace {

/// A number with decimals, without those at its end that are zero.
std::string shortest(std::string text) {
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text == "-0" ? "0" : text;
}

}  // namespace

std::string stamp_text(double seconds) {
  constexpr double largest = 1e15;  // beyond it a double has no decimals
  return std::abs(seconds) < largest ? shortest(fmt::format("{:.6f}", seconds)) : fmt::format("{:g}", seconds);
}

std::string stamp_text(std::int64_t ns) {
  constexpr std::uint64_t second = 1'000'000'000;
  const std::uint64_t size = ns < 0 ? 0 - static_cast<std::uint64_t>(ns) : static_cast<std::uint64_t>(ns);
  return shortest(fmt::format("{}{}.{:09}", ns < 0 ? "-" : "", size / second, size % second));
}

}  // namespace imulab
