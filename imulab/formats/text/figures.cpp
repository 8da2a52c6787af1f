#include "imulab/formats/text/figures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace imulab::text {

namespace {

/// The power of ten of the first digit, after rounding to two digits.
int exponent_of(double size) {
  const int exponent = static_cast<int>(std::floor(std::log10(size)));
  return std::round(size / std::pow(10, exponent - 1)) >= 100 ? exponent + 1 : exponent;
}

constexpr int least_exponent = -5, largest_exponent = 6;  // beyond them a number is read more easily with its power of ten

std::string to_place(int place, double value) {
  if (place < 0) return fmt::format("{:.{}f}", value, -place);
  const double step = std::pow(10, place);
  return fmt::format("{:.0f}", std::round(value / step) * step + 0.0);
}

std::size_t columns_of(std::string_view word) {
  return static_cast<std::size_t>(std::count_if(word.begin(), word.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0u) != 0x80u; }));
}

}  // namespace

std::string two_digits(double uncertainty) {
  if (!std::isfinite(uncertainty)) return "-";
  if (uncertainty == 0) return "0";
  const int exponent = exponent_of(std::abs(uncertainty));
  if (exponent < least_exponent || exponent > largest_exponent) return fmt::format("{:.1e}", uncertainty);
  return to_place(exponent - 1, uncertainty);
}

std::string to_digits_of(double uncertainty, double value) {
  if (!std::isfinite(uncertainty) || uncertainty == 0) return fmt::format("{:.6g}", value);
  const int exponent = exponent_of(std::abs(uncertainty));
  if (exponent < least_exponent || exponent > largest_exponent) {
    const double step = std::pow(10, exponent - 1), rounded = std::round(value / step) * step;
    if (rounded == 0) return "0";
    return fmt::format("{:.{}e}", rounded, std::max(0, static_cast<int>(std::floor(std::log10(std::abs(rounded)) + 1e-9)) - exponent + 1));
  }
  std::string text = to_place(exponent - 1, value);
  if (text.find_first_not_of("-0.") == std::string::npos && text.starts_with('-')) text.erase(0, 1);  // not -0.00
  return text;
}

std::string number(double value, int digits) {
  const double size = std::abs(value);
  if (!(size >= std::pow(10, digits)) || size >= 1e7) return fmt::format("{:.{}g}", value, digits);
  return to_place(static_cast<int>(std::floor(std::log10(size))) - digits + 1, value);
}

std::string plural(std::size_t count, std::string_view word) { return fmt::format("{} {}{}", count, word, count == 1 ? "" : "s"); }

std::string minutes(double seconds) { return fmt::format("{:.0f} min {:02.0f} s", std::floor(seconds / 60), std::floor(std::fmod(seconds, 60))); }

std::string wrapped(std::string_view first, std::string_view sentence, std::size_t width) {
  std::string text(first);
  std::size_t column = columns_of(first), indent = column;
  bool at_begin = true;
  while (!sentence.empty()) {
    const std::size_t begin = sentence.find_first_not_of(' ');
    if (begin == std::string_view::npos) break;
    sentence.remove_prefix(begin);
    std::size_t end = std::min(sentence.find(' '), sentence.size());
    if (sentence.substr(end).starts_with(" %")) end = std::min(sentence.find(' ', end + 1), sentence.size());  // stays with its number
    const std::string_view word = sentence.substr(0, end);
    sentence.remove_prefix(word.size());
    const std::size_t size = columns_of(word);
    if (!at_begin && column + 1 + size > width) {
      text += "\n" + std::string(indent, ' ');
      column = indent;
      at_begin = true;
    }
    if (!at_begin) text += ' ', ++column;
    text += word;
    column += size;
    at_begin = false;
  }
  return text + "\n";
}

std::string two_ends(std::string_view left, std::string_view right, std::size_t width) {
  return fmt::format("{} {:>{}}", left, right, width - std::min(width, left.size() + 1));
}

}  // namespace imulab::text
