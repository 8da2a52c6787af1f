#include "imulab/formats/recording/csv_layout.hpp"

#include "imulab/core/error.hpp"
#include "imulab/formats/text/decimal.hpp"
#include "imulab/formats/text/printable.hpp"

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
  field = text::without_plus(field);
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
    throw Error(fmt::format("{}: column {} is not there; expected one of {}", file, excerpt(name), text::listed_excerpts(names)));
  if (std::find(found + 1, names.end(), name) != names.end())
    throw Error(fmt::format("{}: column {} is there more than once; expected one of that name, or columns by number", file, excerpt(name)));
  return static_cast<std::size_t>(found - names.begin());
}

bool names_a_column(const TimeSource& time, const std::vector<Column>& columns) {
  const auto is_named = [](const Column& column) { return std::holds_alternative<std::string>(column); };
  return (time.column && is_named(*time.column)) || (time.fraction_column && is_named(*time.fraction_column)) ||
         std::any_of(columns.begin(), columns.end(), is_named);
}

namespace {

/// A line with something in it that is no comment, and what such a line is.
struct Line {
  std::string_view text;
  std::size_t offset = 0, number = 0;
};

/// The first lines of a text.
std::vector<Line> content_lines(std::string_view text, std::size_t begin, std::size_t most) {
  std::vector<Line> lines;
  std::size_t offset = begin, number = 1;
  for (; offset < text.size() && lines.size() < most; ++number) {
    const std::size_t length = std::min(text.find('\n', offset), text.size()) - offset;
    const std::string_view line = text.substr(offset, length), content = trimmed(line);
    if (!content.empty() && content.front() != '#') lines.push_back({line, offset, number});
    offset = std::min(offset + length + 1, text.size());
  }
  return lines;
}

/// A row: half of its fields or more are numbers.
bool is_row(const std::vector<std::string_view>& fields) {
  return 2 * static_cast<std::size_t>(std::count_if(fields.begin(), fields.end(), is_number)) >= fields.size();
}

/// Text of another kind before a table (a device's name, settings).
struct Preamble {
  std::size_t lines = 0;  ///< that have something in them
  bool known = true;      ///< more lines cannot change it
};

/// The table begins with at least four rows of as many fields, of which no line before the header has as many.
Preamble find_preamble(const std::vector<Line>& lines, TableLayout layout) {
  constexpr std::size_t enough = 4;
  for (std::size_t i = 1; i + enough <= lines.size(); ++i) {
    layout.delimiter = delimiter_of(trimmed(lines[i].text));
    const std::size_t columns = fields_of(lines[i].text, layout).size();
    const auto fits = [&](const Line& line) {
      const auto fields = fields_of(line.text, layout);
      return fields.size() == columns && is_row(fields);
    };
    const auto at = lines.begin() + static_cast<std::ptrdiff_t>(i);
    if (columns < 3 || !std::all_of(at, at + enough, fits)) continue;
    const auto header = fields_of(lines[i - 1].text, layout);
    const bool has_header = header.size() == columns && std::none_of(header.begin(), header.end(), is_number);
    const std::size_t first = has_header ? i - 1 : i;
    for (std::size_t k = 0; k < first; ++k)
      if (fields_of(lines[k].text, layout).size() == columns) return {};  // a damaged row rather than text
    return {first, true};
  }
  return {0, false};
}

/// The names in a comment directly before the rows, if there are as many.
std::vector<std::string> commented_names(std::string_view text, std::size_t offset, const TableLayout& layout) {
  std::string_view before = text.substr(0, offset), comment;
  while (comment.empty() && !before.empty()) {
    before = before.substr(0, before.size() - 1);  // the line's end
    const std::size_t begin = before.rfind('\n') + 1;
    const std::string_view content = trimmed(before.substr(begin));
    if (!content.empty() && content.front() == '#') comment = content.substr(1);
    if (!content.empty() && content.front() != '#') break;
    before = before.substr(0, begin);
  }
  std::vector<std::string> names = comment.empty() ? std::vector<std::string>{} : names_of(comment, layout);
  return names.size() == layout.columns ? names : std::vector<std::string>{};
}

}  // namespace

std::optional<TableLayout> find_layout(const std::string& file, std::string_view text, bool named, bool complete) {
  constexpr std::size_t longest_preamble = 200;  // lines
  TableLayout layout;
  layout.file = file;
  if (text.substr(0, 4096).find('\0') != std::string_view::npos) throw Error(file + ": is not text; expected CSV or plain columns of numbers");
  const std::size_t begin = text.starts_with("\xEF\xBB\xBF") ? 3 : 0;  // UTF-8 byte order mark
  const std::vector<Line> lines = content_lines(text, begin, longest_preamble);
  if (lines.empty()) return std::nullopt;
  const Preamble preamble = find_preamble(lines, layout);
  const std::size_t first = preamble.lines;
  if (first > 0) layout.skipped = lines[first].number - 1;
  layout.settled = complete || preamble.known || lines.size() == longest_preamble;
  layout.delimiter = delimiter_of(trimmed(lines[first].text));
  const auto fields = fields_of(lines[first].text, layout);
  layout.columns = fields.size();
  const auto a_row = [&](const Line& line) { return is_row(fields_of(line.text, layout)); };
  if (complete && lines.size() > first + 1 && std::none_of(lines.begin() + static_cast<std::ptrdiff_t>(first), lines.end(), a_row))
    throw Error(file + ": has no row of numbers; expected CSV or plain columns of numbers");  // of another kind of file nothing is quoted
  const bool header = std::none_of(fields.begin(), fields.end(), is_number);                  // a row with one bad field is a bad row, not a header
  if (header) layout.names = names_of(lines[first].text, layout);
  if (header && first + 1 == lines.size()) return std::nullopt;
  const Line& row = lines[header ? first + 1 : first];
  if (!complete && header && fields_of(row.text, layout).size() != layout.columns) return std::nullopt;  // a preamble, as what follows may show
  layout.offset = row.offset;
  layout.line = row.number;
  if (!header) layout.names = commented_names(text, row.offset, layout);
  if (named && layout.names.empty() && !layout.settled) return std::nullopt;
  if (named && layout.names.empty())
    throw Error(fmt::format("{}:{}: has no header; expected one because columns are named (or give columns by number)", file, layout.line));
  return layout;
}

TableLayout table_layout(const std::string& file, std::string_view text, bool named) {
  if (auto layout = find_layout(file, text, named, true)) return *std::move(layout);
  const bool header = !content_lines(text, 0, 1).empty();  // a row would have been found
  throw Error(fmt::format("{}: {}; expected rows of numbers", file, text.empty() ? "is empty" : header ? "has a header but no rows" : "has no rows"));
}

}  // namespace imulab::recording_io
