#include "imulab/formats/recording/text/encoding.hpp"

#include <algorithm>
#include <cstddef>

namespace imulab::recording_io {
namespace {

void append_utf8(std::string& out, unsigned c) {
  const auto byte = [&](unsigned value) { out.push_back(static_cast<char>(value)); };
  const auto tail = [&](unsigned shift) { byte(0x80U | ((c >> shift) & 0x3FU)); };
  if (c < 0x80) return byte(c);
  if (c < 0x800) return byte(0xC0U | (c >> 6U)), tail(0);
  if (c < 0x10000) return byte(0xE0U | (c >> 12U)), tail(6), tail(0);
  byte(0xF0U | (c >> 18U)), tail(12), tail(6), tail(0);
}

unsigned char at(std::string_view text, std::size_t i) { return static_cast<unsigned char>(text[i]); }

/// Zeros in every other byte of the first ones: ASCII in UTF-16. `odd`: where they are.
bool zeros_alternate(std::string_view head, std::size_t odd) {
  constexpr std::size_t enough = 8, most = 64;
  const std::size_t count = std::min(head.size(), most) / 2;
  if (2 * count < enough) return false;
  for (std::size_t i = 0; i < count; ++i)
    if (head[2 * i + odd] != '\0' || head[2 * i + 1 - odd] == '\0') return false;
  return true;
}

}  // namespace

std::optional<TextBytes> recognize_bytes(std::string_view head, bool complete) {
  constexpr std::size_t looked_at = std::size_t{1} << 16;
  TextBytes bytes;
  if (head.starts_with("\xFF\xFE")) {
    bytes = {Encoding::utf16_low_first, 2};
  } else if (head.starts_with("\xFE\xFF")) {
    bytes = {Encoding::utf16_high_first, 2};
  } else if (head.starts_with("\xEF\xBB\xBF")) {
    bytes.mark = 3;
  } else if (zeros_alternate(head, 1)) {
    bytes.encoding = Encoding::utf16_low_first;
  } else if (zeros_alternate(head, 0)) {
    bytes.encoding = Encoding::utf16_high_first;
  }
  head = head.substr(0, looked_at);
  if (head.find('\n') != std::string_view::npos) return bytes;
  const auto returns = std::count(head.begin(), head.end(), '\r');
  if (returns < 2 && !complete) return std::nullopt;
  bytes.carriage_returns = returns > 0;
  return bytes;
}

bool may_be_text(std::string_view head) {
  if (const auto bytes = recognize_bytes(head, true); bytes->encoding != Encoding::utf8) return true;
  const std::string_view text = without_erased(head);
  return head.empty() || (!text.empty() && text.find('\0') == std::string_view::npos);
}

std::string_view without_erased(std::string_view text) {
  while (!text.empty() && (text.back() == '\0' || text.back() == '\xFF')) text.remove_suffix(1);
  return text;
}

void Decoder::unit(unsigned value, std::string& out) {
  constexpr unsigned high_first = 0xD800, low_first = 0xDC00, end = 0xE000, unknown = 0xFFFD;
  if (value >= high_first && value < low_first) {
    if (high_ != 0) append_utf8(out, unknown);
    high_ = value;
    return;
  }
  const bool low = value >= low_first && value < end;
  if (high_ != 0) append_utf8(out, low ? 0x10000 + ((high_ - high_first) << 10U) + (value - low_first) : unknown);
  if (!(low && high_ != 0)) append_utf8(out, low ? unknown : value);
  high_ = 0;
}

void Decoder::add(std::string_view bytes, bool last, std::string& out) {
  const std::size_t skipped = std::min(skip_, bytes.size()), begin = out.size();
  bytes.remove_prefix(skipped), skip_ -= skipped;
  if (bytes_.encoding == Encoding::utf8) {
    out.append(bytes);
  } else {
    std::string joined;
    if (!rest_.empty()) joined = rest_ + std::string(bytes), bytes = joined;
    const std::size_t low = bytes_.encoding == Encoding::utf16_low_first ? 0 : 1;
    out.reserve(out.size() + bytes.size() / 2);
    for (std::size_t i = 0; i + 1 < bytes.size(); i += 2) {
      const unsigned value = at(bytes, i + low) | static_cast<unsigned>(at(bytes, i + 1 - low)) << 8U;
      if (value < 0x80 && high_ == 0) {
        out.push_back(static_cast<char>(value));
      } else {
        unit(value, out);
      }
    }
    rest_ = bytes.size() % 2 == 1 ? std::string(1, bytes.back()) : std::string();
  }
  if (!bytes_.carriage_returns) return;
  for (std::size_t i = begin; i < out.size(); ++i) {
    if (out[i] == '\n' && returned_)
      out[i] = ' ', returned_ = false;  // the line has ended with the \r before
    else if (returned_ = out[i] == '\r'; returned_)
      out[i] = '\n';
  }
  if (last) returned_ = false;
}

std::string utf8_name(std::string_view name) {
  std::size_t i = 0;
  while (i < name.size()) {
    const unsigned char c = at(name, i);
    const std::size_t tail = c < 0x80 ? 0 : c >= 0xC2 && c < 0xE0 ? 1 : c >= 0xE0 && c < 0xF0 ? 2 : c >= 0xF0 && c < 0xF5 ? 3 : name.size();
    if (tail > name.size() - i - 1) break;
    const auto first = name.begin() + static_cast<std::ptrdiff_t>(i) + 1;
    if (!std::all_of(first, first + static_cast<std::ptrdiff_t>(tail), [](char t) { return (static_cast<unsigned char>(t) & 0xC0U) == 0x80; })) break;
    i += tail + 1;
  }
  if (i == name.size()) return std::string(name);
  std::string out;
  for (std::size_t k = 0; k < name.size(); ++k) append_utf8(out, at(name, k));
  return out;
}

}  // namespace imulab::recording_io
