#include "imulab/formats/recording/table.hpp"

#include "imulab/error.hpp"
#include "imulab/formats/text/printable.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <iterator>
#include <string_view>
#include <variant>

namespace imulab::recording_io {
namespace {

std::string table_names(const std::vector<TableDescription>& tables) {
  std::vector<std::string_view> names;
  for (const TableDescription& table : tables) names.push_back(table.name);
  return text::listed(names);
}

}  // namespace

void RawColumn::make_numbers() {
  if (integers.empty()) return;
  numbers.insert(numbers.end(), integers.begin(), integers.end());
  integers = {};
}

void RawColumn::append(RawColumn&& next) {
  if (size() == 0) return void(*this = std::move(next));
  if (!numbers.empty() || !next.numbers.empty()) make_numbers(), next.make_numbers();
  numbers.insert(numbers.end(), next.numbers.begin(), next.numbers.end());
  integers.insert(integers.end(), next.integers.begin(), next.integers.end());
}

std::size_t LineNumbers::operator[](std::size_t row) const {
  const auto after = std::upper_bound(jumps_.begin(), jumps_.end(), row, [](std::size_t r, const auto& jump) { return r < jump.first; });
  if (after == jumps_.begin()) return 0;
  return row + (std::prev(after)->second - std::prev(after)->first);
}

void LineNumbers::append(const LineNumbers& next, std::size_t row, std::size_t line) {
  for (const auto& [own_row, own_line] : next.jumps_) add(row + own_row, line + own_line);
}

std::string TableRows::place(std::size_t index) const {
  const std::size_t line = lines[index];
  return line > 0 ? "line " + std::to_string(line) : row + " " + std::to_string(first + index + 1);
}

bool TableDescription::has_name(const std::string& topic) const {
  return name == topic || std::find(other_names.begin(), other_names.end(), topic) != other_names.end();
}

const TableDescription& find_table(const std::vector<TableDescription>& tables, const std::string& topic, const std::string& file) {
  if (tables.empty()) throw Error(fmt::format("{}: has no table of numbers; expected samples", file));
  if (topic.empty()) {
    if (tables.size() == 1) return tables.front();
    throw Error(fmt::format("{}: has several topics and the session names none; expected topic = one of {}", file, table_names(tables)));
  }
  const auto found = std::find_if(tables.begin(), tables.end(), [&](const TableDescription& t) { return t.has_name(topic); });
  if (found == tables.end()) throw Error(fmt::format("{}: topic {} is not there; expected one of {}", file, topic, table_names(tables)));
  return *found;
}

Column column_named(const std::string& name, std::size_t index) {
  if (name.empty() || name.find(sum_sign) != std::string::npos) return static_cast<int>(index) + 1;
  return name;
}

Error no_column(const std::string& where, const std::string& name, const std::vector<std::string>& names) {
  const char* const sum = name.find('+') != std::string::npos ? "; a sum is written A + B, with blanks, and is one of readings" : "";
  return Error(fmt::format("{}: column {} is not there{}{}", where, name.empty() ? "\"\"" : excerpt(name), text::expected_excerpt(name, names), sum));
}

std::size_t find_column(const TableDescription& table, const Column& column, const std::string& file) {
  const std::string where = table.name.empty() ? file : fmt::format("{}: {}", file, table.name);
  if (const int* number = std::get_if<int>(&column)) {
    if (*number >= 1 && static_cast<std::size_t>(*number) <= table.columns.size()) return static_cast<std::size_t>(*number) - 1;
    throw Error(fmt::format("{}: column {} is not there; expected 1 to {}", where, *number, table.columns.size()));
  }
  const std::string& name = std::get<std::string>(column);
  const auto found = std::find_if(table.columns.begin(), table.columns.end(), [&](const ColumnDescription& c) { return c.name == name; });
  if (found != table.columns.end()) return static_cast<std::size_t>(found - table.columns.begin());
  std::vector<std::string> names;
  for (const ColumnDescription& c : table.columns) names.push_back(c.name);
  throw no_column(where, name, names);
}

}  // namespace imulab::recording_io
