#include "imulab/export/c_header_text.hpp"

#include "imulab/core/error.hpp"

#include <fmt/format.h>

#include <cctype>
#include <cmath>

namespace imulab::firmware {

std::string literal(double value) {
  if (!std::isfinite(value)) throw Error("the header's numbers would be too large; expected a calibration and readings of an IMU");
  std::string text = fmt::format("{}", value);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return fmt::format("(imulab_real){}", value < 0 ? "(" + text + ")" : text);
}

std::string literal(std::int64_t value) {
  constexpr std::int64_t half = std::int64_t{1} << 30, whole = 2 * half;
  if (value > -whole && value < whole) return value < 0 ? fmt::format("({})", value) : fmt::format("{}", value);
  return fmt::format("((int64_t){} * {} + ({}))", literal(value / half), half, value % half);
}

std::string harmless(std::string_view text) {
  constexpr std::size_t longest = 100;
  constexpr std::string_view allowed = " .,:;()[]{}<>=+-_/@#%&!~^|'";  // no quote, backslash, asterisk or question mark (of trigraphs)
  std::string out;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if ((byte & 0xC0u) == 0x80u) continue;  // a further byte of a UTF-8 character
    if (out.size() == longest) return out + "...";
    out += byte < 0x80 && (std::isalnum(byte) || allowed.find(c) != std::string_view::npos) ? c : '_';
  }
  return out;
}

std::string unit_in_name(std::string_view unit) {
  std::string out;
  for (const char c : unit) {
    if (c == '/')
      out += "_per_";
    else if (std::isalnum(static_cast<unsigned char>(c)))
      out += c;
    else if (c != '^')
      out += '_';
  }
  return out;
}

}  // namespace imulab::firmware
