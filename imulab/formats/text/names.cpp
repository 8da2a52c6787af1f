#include "imulab/formats/text/names.hpp"

#include "imulab/formats/text/printable.hpp"

#include <algorithm>
#include <numeric>

namespace imulab::text {
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

}  // namespace

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

std::string_view nearest_name(std::string_view word, const std::vector<std::string_view>& names) {
  constexpr std::size_t longest = 100;  // the search takes the product of both lengths
  if (word.size() > longest) return {};
  std::string_view best;
  std::size_t least = std::max<std::size_t>(2, word.size() / 3) + 1;
  for (const std::string_view name : names)
    if (const std::size_t n = edits(word, name); n < least && n < name.size()) best = name, least = n;
  return best;
}

}  // namespace imulab::text
