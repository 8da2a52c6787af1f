#include "imulab/io/recording/csv_layout.hpp"

#include "imulab/core/error.hpp"
#include "imulab/io/text/names.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <utility>

namespace imulab::recording_io {
namespace {

std::string_view trimmed(std::string_view text, std::string_view blanks = " \t\r") {
  const std::size_t first = text.find_first_not_of(blanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

bool is_number(std::string_view field) {
  if (!field.empty() && field.front() == '+') field.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  return error != std::errc::invalid_argument && end == field.data() + field.size();
}

char delimiter_of(std::string_view line) {
  for (const char c : {';', ',', '\t'})  // a comma may be a decimal one beside a semicolon, a tab a mere blank beside either
    if (line.find(c) != std::string_view::npos) return c;
  return ' ';
}

std::vector<std::string> names_of(std::string_view line, const TableLayout& layout) {
  std::vector<std::string> names;
  for (const std::string_view field : fields_of(line, layout)) names.emplace_back(trimmed(field, " \t\r\""));
  return names;
}

}  // namespace

std::vector<std::string_view> fields_of(std::string_view line, const TableLayout& layout) {
  std::vector<std::string_view> fields;
  line = layout.delimiter == '\t' ? trimmed(line, " \r") : trimmed(line);
  while (true) {
    const std::size_t end = layout.delimiter == ' ' ? line.find_first_of(" \t") : line.find(layout.delimiter);
    fields.push_back(trimmed(line.substr(0, end)));
    if (end == std::string_view::npos) return fields;
    line.remove_prefix(end + 1);
    if (layout.delimiter == ' ') line = trimmed(line);
  }
}

std::string TableLayout::column_name(std::size_t index) const {
  return index < names.size() && !names[index].empty() ? names[index] : fmt::format("column {}", index + 1);
}

std::size_t TableLayout::find(const Column& column) const {
  if (const int* number = std::get_if<int>(&column)) {
    if (*number >= 1 && static_cast<std::size_t>(*number) <= columns) return static_cast<std::size_t>(*number) - 1;
    throw Error(fmt::format("{}: column {} is not there; expected 1 to {}", file, *number, columns));
  }
  const std::string& name = std::get<std::string>(column);
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end())
    throw Error(fmt::format("{}: column {} is not there; expected one of {}", file, name, text::listed({names.begin(), names.end()})));
  if (std::find(found + 1, names.end(), name) != names.end())
    throw Error(fmt::format("{}: column {} is there more than once; expected one of that name, or columns by number", file, name));
  return static_cast<std::size_t>(found - names.begin());
}

bool names_a_column(const TimeSource& time, const std::vector<Column>& columns) {
  const auto is_named = [](const Column& column) { return std::holds_alternative<std::string>(column); };
  return (time.column && is_named(*time.column)) || (time.fraction_column && is_named(*time.fraction_column)) ||
         std::any_of(columns.begin(), columns.end(), is_named);
}

std::optional<TableLayout> find_layout(const std::string& file, std::string_view text, bool named) {
  TableLayout layout;
  layout.file = file;
  if (text.substr(0, 4096).find('\0') != std::string_view::npos) throw Error(file + ": is not text; expected CSV or plain columns of numbers");
  if (text.starts_with("\xEF\xBB\xBF")) layout.offset = 3;  // UTF-8 byte order mark
  std::string_view comment;
  for (bool header = false; layout.offset < text.size(); ++layout.line) {
    const std::size_t length = std::min(text.find('\n', layout.offset), text.size()) - layout.offset;
    const std::string_view line = text.substr(layout.offset, length);
    const std::string_view content = trimmed(line);
    const std::size_t next = std::min(layout.offset + length + 1, text.size());
    if (content.empty() || content.front() == '#') {
      if (!content.empty() && !header) comment = content;
      layout.offset = next;
      continue;
    }
    if (header) return layout;
    layout.delimiter = delimiter_of(content);
    const auto fields = fields_of(line, layout);
    layout.columns = fields.size();
    if (std::none_of(fields.begin(), fields.end(), is_number)) {  // a row with one bad field is a bad row, not a header
      header = true;
      layout.names = names_of(line, layout);
      layout.offset = next;
      continue;
    }
    if (!named) return layout;
    if (!comment.empty()) layout.names = names_of(comment.substr(1), layout);  // a header may be a comment
    if (layout.names.size() == layout.columns) return layout;
    throw Error(fmt::format("{}:{}: has no header; expected one because columns are named (or give columns by number)", file, layout.line));
  }
  return std::nullopt;
}

TableLayout table_layout(const std::string& file, std::string_view text, bool named) {
  if (auto layout = find_layout(file, text, named)) return *std::move(layout);
  const bool header = !find_layout(file, std::string(text) + "\n0", false)->names.empty();  // of what a row would have
  throw Error(fmt::format("{}: {}; expected rows of numbers", file, text.empty() ? "is empty" : header ? "has a header but no rows" : "has no rows"));
}

}  // namespace imulab::recording_io
