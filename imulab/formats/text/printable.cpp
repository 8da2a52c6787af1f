#include "imulab/formats/text/printable.hpp"

#include "imulab/core/nearest_name.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <numeric>

namespace imulab {

namespace {

struct CodePoint {
  std::uint32_t value = 0;
  std::size_t bytes = 0;  // 0: no UTF-8
};

/// The first character of a text (RFC 3629).
CodePoint first_of(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<std::uint32_t>(static_cast<unsigned char>(text[i])); };
  const std::uint32_t head = byte(0);
  if (head < 0x80) return {head, 1};
  const std::size_t bytes = head >= 0xf0 ? 4 : head >= 0xe0 ? 3 : 2;
  if (head < 0xc2 || head > 0xf4 || text.size() < bytes) return {};
  std::uint32_t value = head & (0x7fu >> bytes);
  for (std::size_t i = 1; i < bytes; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return {};
    value = value << 6 | (byte(i) & 0x3f);
  }
  constexpr std::uint32_t least[] = {0, 0, 0x80, 0x800, 0x10000};
  const bool surrogate = value >= 0xd800 && value < 0xe000;
  return value < least[bytes] || value > 0x10ffff || surrogate ? CodePoint{} : CodePoint{value, bytes};
}

/// Controls of the sets C0 and C1, and of the direction of writing.
bool steers(std::uint32_t c) {
  return c < 0x20 || (c >= 0x7f && c < 0xa0) || c == 0x61c || c == 0x200e || c == 0x200f || (c >= 0x2028 && c <= 0x202e) ||
         (c >= 0x2066 && c <= 0x2069);
}

std::string shown(std::string_view text, bool lines, std::size_t most) {
  std::string out;
  std::size_t count = 0;
  while (!text.empty() && count++ < most) {
    const CodePoint c = first_of(text);
    const std::size_t bytes = std::max<std::size_t>(c.bytes, 1);
    if (c.bytes > 0 && (!steers(c.value) || (lines && (c.value == '\n' || c.value == '\t')))) {
      out.append(text.substr(0, bytes));
    } else {
      for (const char byte : text.substr(0, bytes)) fmt::format_to(std::back_inserter(out), "\\x{:02x}", static_cast<unsigned char>(byte));
    }
    text.remove_prefix(bytes);
  }
  return text.empty() ? out : out + "...";
}

}  // namespace

std::string printable(std::string_view text) { return shown(text, true, text.size()); }

std::string one_line(std::string_view text) { return shown(text, false, text.size()); }

std::string with_escapes(std::string_view text) {
  if (std::all_of(text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 0x7f; })) return std::string(text);
  std::string out;
  while (!text.empty()) {
    const CodePoint c = first_of(text);
    const std::size_t bytes = std::max<std::size_t>(c.bytes, 1);
    out += c.bytes > 0 && c.value >= 0x7f && steers(c.value) ? fmt::format("\\u{:04X}", c.value) : std::string(text.substr(0, bytes));
    text.remove_prefix(bytes);
  }
  return out;
}

std::string excerpt(std::string_view text, std::size_t most) { return shown(text, false, most); }

}  // namespace imulab

namespace imulab::text {

std::string listed(const std::vector<std::string_view>& names) {
  std::string text;
  for (const std::string_view name : names) text.append(text.empty() ? "" : ", ").append(name);
  return text;
}

std::string listed_excerpts(const std::vector<std::string>& names) {
  constexpr std::size_t most = 20;
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), most); ++i) text.append(i == 0 ? "" : ", ").append(excerpt(names[i]));
  return names.size() > most ? text + ", ..." : text;
}

std::string expected_excerpt(std::string_view name, const std::vector<std::string>& names) {
  return "; expected one of " + listed_excerpts(names) + did_you_mean(excerpt(name), names);
}

}  // namespace imulab::text
