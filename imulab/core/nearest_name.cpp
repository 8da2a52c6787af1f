#include "imulab/core/nearest_name.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <numeric>

namespace imulab {

namespace {

/// Letters to insert, delete or replace (Levenshtein).
std::size_t edits(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replace = diagonal + (a[i - 1] != b[j - 1]);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replace});
    }
  }
  return row.back();
}

bool same_letters(std::string_view a, std::string_view b) {
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; };
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [&](char x, char y) { return lower(x) == lower(y); });
}

}  // namespace

std::string_view nearest_name(std::string_view word, const std::vector<std::string_view>& names) {
  constexpr std::size_t longest = 100;  // the search takes the product of both lengths
  if (word.size() > longest) return {};
  for (const std::string_view name : names)
    if (same_letters(word, name)) return name;
  std::string_view best;
  if (const auto letter = word.find_first_not_of('-'); letter != std::string_view::npos && word.size() - letter >= 3)
    for (const std::string_view name : names)
      if (name.starts_with(word) && (best.empty() || name.size() < best.size())) best = name;
  if (!best.empty()) return best;
  std::size_t least = std::max<std::size_t>(2, word.size() / 3) + 1;
  for (const std::string_view name : names)
    if (name.size() <= longest)
      if (const std::size_t n = edits(word, name); n < least && n < name.size()) best = name, least = n;
  return best;
}

std::string did_you_mean(std::string_view word, const std::vector<std::string_view>& names) {
  const std::string_view nearest = nearest_name(word, names);
  return nearest.empty() ? "" : "; did you mean " + std::string(nearest) + "?";
}

std::string did_you_mean(std::string_view word, const std::vector<std::string>& names) {
  return did_you_mean(word, std::vector<std::string_view>(names.begin(), names.end()));
}

std::string expected_name(std::string_view word, const std::vector<std::string_view>& names) {
  const std::string meant = did_you_mean(word, names);
  return !meant.empty() ? meant : names.empty() ? "" : fmt::format("; expected one of {}", fmt::join(names, ", "));
}

std::string expected_name(std::string_view word, const std::vector<std::string>& names) {
  return expected_name(word, std::vector<std::string_view>(names.begin(), names.end()));
}

}  // namespace imulab
