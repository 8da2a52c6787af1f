#include "imulab/formats/text/csv_field.hpp"

#include "imulab/formats/text/printable.hpp"

#include <algorithm>
#include <charconv>

namespace imulab::text {

namespace {

bool is_plain_number(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

}  // namespace

/// Spreadsheets take the wide forms of these characters, too (U+FF1D and so on).
bool would_run(std::string_view text) {
  if (text.starts_with('\t') || text.starts_with('\r') || text.starts_with('\n')) return true;
  text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
  for (const std::string_view sign : {"=", "+", "-", "@", "\uFF1D", "\uFF0B", "\uFF0D", "\uFF20"})
    if (text.starts_with(sign)) return !is_plain_number(text);
  return false;
}

std::string csv_field(std::string_view text) {
  const std::string shown = (would_run(text) ? "'" : "") + one_line(text);
  if (shown.find_first_of(",;\"") == std::string::npos) return shown;
  std::string quoted = "\"";
  for (const char c : shown) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

}  // namespace imulab::text
