// Tables of the manual that follow from tables of the program. Each stands in its page between two comments:
//
//     <!-- table: units -->      written by the program's own words and names (page_tables_test.cpp)
//     <!-- keys: [imu] -->       written by hand; its first column has exactly the program's names. Where the second one is headed "key", each row is
//                                about the tables "NAME FIRST", by all that the first column or the one above it has
//     <!-- fields: noise -->     written by hand, of the JSON that is printed (described_fields_test.cpp)
//     <!-- end -->
#pragma once

#include "tests/console_page.hpp"
#include <algorithm>
#include <map>
#include <ostream>
#include <regex>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

namespace imulab {

/// Rows of cells; the first row is the head.
using PageTable = std::vector<std::vector<std::string>>;

/// A part of a page that a comment names: the lines after it, up to the next comment "end".
struct MarkedPart {
  std::string kind, name;
  std::size_t begin = 0, end = 0;  ///< lines of the page, from 0
};

inline std::vector<MarkedPart> marked_parts(const std::vector<std::string>& page) {
  std::vector<MarkedPart> parts;
  static const std::regex mark("<!-- ([a-z]+): (.+) -->");
  for (std::size_t i = 0; i < page.size(); ++i) {
    std::smatch found;
    if (!std::regex_match(page[i], found, mark)) continue;
    const auto end = std::find(page.begin() + static_cast<std::ptrdiff_t>(i), page.end(), "<!-- end -->");
    if (end == page.end()) throw std::runtime_error(page[i] + " has no end");
    parts.push_back({found[1], found[2], i + 1, static_cast<std::size_t>(end - page.begin())});
  }
  return parts;
}

/// A text of the program in a cell: options and quoted values as code, nothing that Markdown would take for its own.
inline std::string cell_text(std::string text) {
  static const std::vector<std::pair<std::regex, const char*>> changes{
      {std::regex(" \\[([^\\[\\]]+, [^\\[\\]]+)\\]( \\(default: [^)]*\\))?$"), ". Values: $1$2"},
      {std::regex("\"([^\"]*)\""), "`$1`"},
      {std::regex("(^|[ (])(--?[a-z][a-z0-9-]*)"), "$1`$2`"},
      {std::regex("<(?=[a-z])"), "&lt;"},
      {std::regex("([|*]|\\[\\[)"), "\\$1"}};
  for (const auto& [pattern, form] : changes) text = std::regex_replace(text, pattern, form);
  return text;
}

inline std::string as_code(const std::string& text) { return text.empty() ? "" : "`" + text + "`"; }

/// As Markdown, with empty lines around it.
inline std::vector<std::string> table_lines(const PageTable& table) {
  std::vector<std::string> lines{""};
  for (const std::vector<std::string>& row : table) {
    std::string line = "|", rule = "|";
    for (const std::string& cell : row) line += (cell.empty() ? "" : " " + cell) + " |", rule += " --- |";
    lines.push_back(line);
    if (lines.size() == 2) lines.push_back(rule);
  }
  lines.emplace_back("");
  return lines;
}

/// A key of a table that is written by hand.
struct TableKey {
  std::string name;
  bool required = false;  ///< marked by \*
  auto operator<=>(const TableKey&) const = default;
  friend void PrintTo(const TableKey& key, std::ostream* out) { *out << key.name << (key.required ? "*" : ""); }
};

using TableKeys = std::map<std::string, std::set<TableKey>>;  ///< by the name of the table

/// Adds the keys of a part, each of them code.
inline void add_keys(const std::vector<std::string>& page, const MarkedPart& part, TableKeys& keys) {
  static const std::regex code("`([^`]+)`(\\\\\\*)?"), cells("\\| ?(.*?) ?\\| ?(.*?) \\|.*");
  using Codes = std::sregex_iterator;
  std::vector<std::string> names;
  bool by_table = false;
  for (std::size_t i = part.begin; i < part.end; ++i) {
    std::smatch row;
    if (!std::regex_match(page[i], row, cells)) continue;
    const std::string first = row[1], second = row[2];
    if (page[i - 1].empty()) {  // the head
      by_table = second == "key" || second == "keys" || second == "columns";
      if (!by_table) names = {part.name};
      continue;
    }
    if (by_table && !first.empty()) {
      names.clear();
      for (Codes at(first.begin(), first.end(), code), end; at != end; ++at) names.push_back(part.name + " " + (*at)[1].str());
      if (names.empty()) names = {part.name + " " + first};
    }
    const std::string& cell = by_table ? second : first;
    for (Codes at(cell.begin(), cell.end(), code), end; at != end; ++at)
      for (const std::string& name : names) keys[name].insert({(*at)[1], (*at)[2].matched});
  }
}

}  // namespace imulab
