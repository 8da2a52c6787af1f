#include "imulab/formats/import/numbers.hpp"

#include "imulab/formats/text/decimal.hpp"
#include "imulab/formats/text/printable.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace imulab::import_io {

std::optional<double> finite_number(std::string_view text) {
  text = imulab::text::without_plus(text);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::vector<Line> lines_of(std::string_view text) {
  std::vector<Line> out;
  int number = 0;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    ++number;
    line = line.substr(0, line.find_first_of("#%"));
    const std::size_t first = line.find_first_not_of(" \t\r"), last = line.find_last_not_of(" \t\r");
    if (first != std::string_view::npos) out.push_back({number, line.substr(first, last - first + 1)});
  }
  return out;
}

std::vector<std::string_view> words_of(std::string_view text, std::string_view separators) {
  std::vector<std::string_view> out;
  for (std::size_t begin = text.find_first_not_of(separators); begin != std::string_view::npos; begin = text.find_first_not_of(separators)) {
    text.remove_prefix(begin);
    out.push_back(text.substr(0, text.find_first_of(separators)));
    text.remove_prefix(out.back().size());
  }
  return out;
}

bool has_key(std::string_view text, std::string_view key) {
  for (const Line& line : lines_of(text))
    for (std::size_t at = line.text.find(key); at != std::string_view::npos; at = line.text.find(key, at + 1)) {
      if (at > 0 && std::string_view(" \t{,-\"'").find(line.text[at - 1]) == std::string_view::npos) continue;
      std::string_view rest = line.text.substr(at + key.size());
      if (rest.starts_with('"') || rest.starts_with('\'')) rest.remove_prefix(1);
      rest.remove_prefix(std::min(rest.find_first_not_of(' '), rest.size()));
      if (rest.starts_with(':')) return true;
    }
  return false;
}

Numbers numbers_of(const Source& source, std::size_t most) {
  Numbers out;
  for (const Line& line : lines_of(source.text))
    for (const std::string_view word : words_of(line.text)) {
      const auto value = finite_number(word);
      if (!value) fail_at(source, line.number, fmt::format("\"{}\": expected a number", excerpt(word)));
      if (out.values.size() == most) fail_at(source, line.number, fmt::format("more than {} numbers; expected no more", most));
      out.values.push_back(*value);
      out.lines.push_back(line.number);
    }
  return out;
}

Matrix3d matrix_from(const double* values) { return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(values); }

}  // namespace imulab::import_io
