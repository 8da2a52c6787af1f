#include "imulab/formats/recording/text/csv_layout.hpp"

#include "imulab/core/text.hpp"
#include "imulab/error.hpp"
#include "imulab/formats/recording/table.hpp"
#include "imulab/formats/recording/text/encoding.hpp"
#include "imulab/formats/text/decimal.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/formats/text/take_until.hpp"
#include "imulab/inspection/names.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <utility>

namespace imulab::recording_io {
namespace {

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

std::vector<std::string> names_for_rows_of(std::string_view lines, std::string_view sensor, char delimiter) {
  constexpr std::size_t looked_at = std::size_t{1} << 16;  // bytes
  TableLayout layout;
  layout.delimiter = delimiter;
  lines = lines.substr(0, looked_at);
  while (!lines.empty() && !sensor.empty() && !is_number(sensor)) {
    const std::string_view line = trimmed(text::take_until(lines, '\n'));
    if (!line.starts_with('#')) continue;
    std::vector<std::string> names = names_of(line.substr(1), layout);
    if (names.front() == sensor) return names;
  }
  return {};
}

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

std::string TableLayout::at(std::size_t number) const {
  return counts_elements ? fmt::format("{}: element {}", file, number) : fmt::format("{}:{}", file, number);
}

std::size_t TableLayout::find(const Column& column) const {
  if (const int* number = std::get_if<int>(&column)) {
    if (*number >= 1 && static_cast<std::size_t>(*number) <= columns) return static_cast<std::size_t>(*number) - 1;
    throw Error(fmt::format("{}: column {} is not there; expected 1 to {}", file, *number, columns));
  }
  const std::string& name = std::get<std::string>(column);
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) throw no_column(file, name, names);
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

/// A row: half of its fields that are not empty or more are numbers.
bool is_row(const std::vector<std::string_view>& fields) {
  const auto numbers = std::count_if(fields.begin(), fields.end(), is_number);
  const auto filled = std::count_if(fields.begin(), fields.end(), [](std::string_view field) { return !field.empty(); });
  return numbers >= 1 && 2 * numbers >= filled;
}

/// "0,1,2,...", or from 1 on: numbers of the columns, as data frames without names are written.
bool numbers_columns(const std::vector<std::string_view>& fields) {
  if (fields.size() < 4 || (fields[0] != "0" && fields[0] != "1")) return false;
  for (std::size_t i = 0; i < fields.size(); ++i)
    if (fields[i] != std::to_string(i + (fields[0] == "0" ? 0 : 1))) return false;
  return true;
}

bool has_numbers(const std::vector<std::string_view>& fields) { return std::any_of(fields.begin(), fields.end(), is_number); }

/// Text of another kind before a table (a device's name, settings).
struct Preamble {
  std::size_t lines = 0;  ///< that have something in them
  bool known = true;      ///< more lines cannot change it
};

constexpr std::size_t longest_header = 3;  // lines: a label of each sensor, names, units

/// The table begins with at least four rows of as many fields, of which no line before the header has as many.
Preamble find_preamble(const std::vector<Line>& lines, TableLayout layout, char delimiter) {
  constexpr std::size_t enough = 4;
  for (std::size_t i = 1; i + enough <= lines.size(); ++i) {
    layout.delimiter = delimiter != 0 ? delimiter : delimiter_of(trimmed(lines[i].text));
    const std::size_t columns = fields_of(lines[i].text, layout).size();
    const auto fits = [&](const Line& line) {
      const auto fields = fields_of(line.text, layout);
      return fields.size() == columns && is_row(fields);
    };
    const auto at = lines.begin() + static_cast<std::ptrdiff_t>(i);
    if (columns < 3 || !std::all_of(at, at + enough, fits)) continue;
    std::size_t first = i;
    while (first > 0 && i - first < longest_header) {
      const auto header = fields_of(lines[first - 1].text, layout);
      if (header.size() != columns || has_numbers(header)) break;
      --first;
    }
    for (std::size_t k = 0; k < first; ++k)
      if (fields_of(lines[k].text, layout).size() == columns) return {};  // a damaged row rather than text
    return {first, true};
  }
  return {0, false};
}

/// The unit in a field under a name: "m/s^2", "[rad/s]"; as it is written where it is none of those known.
std::string unit_in_field(std::string_view field) {
  std::string_view inside = trimmed(field, " \t\r\"");
  const bool in_brackets = inside.size() > 2 && ((inside.front() == '[' && inside.back() == ']') || (inside.front() == '(' && inside.back() == ')'));
  if (in_brackets) inside = trimmed(inside.substr(1, inside.size() - 2));
  const std::string name = utf8_name(inside == "-" ? std::string_view{} : inside);
  const std::string known = inspection::unit_of(name);
  return known.empty() ? name : known;
}

/// A row of units: half of its fields that are not empty or more are some.
bool is_unit_row(const std::vector<std::string_view>& fields) {
  std::size_t units = 0, filled = 0;
  for (const std::string_view field : fields) {
    filled += !field.empty();
    units += !field.empty() && (field == "-" || !inspection::unit_of(unit_in_field(field)).empty());
  }
  return units >= 1 && 2 * units >= filled;
}

/// Names that are there more than once get the name of their group, which stands above the first column of each.
void add_groups(std::vector<std::string>& names, const std::vector<std::string>& groups) {
  std::vector<std::string> sorted = names;
  std::sort(sorted.begin(), sorted.end());
  if (std::adjacent_find(sorted.begin(), sorted.end()) == sorted.end()) return;
  std::string group;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (!groups[i].empty()) group = groups[i];
    if (!group.empty() && group != names[i]) names[i] = names[i].empty() ? group : group + " " + names[i];
  }
}

/// Takes names and units from the lines of a header.
void read_header(const std::vector<Line>& lines, std::size_t begin, std::size_t end, TableLayout& layout) {
  std::vector<std::string> groups;
  for (std::size_t i = begin; i < end; ++i) {
    const auto fields = fields_of(lines[i].text, layout);
    layout.header.emplace_back(trimmed(lines[i].text));
    if (end - begin > 1 && i > begin && layout.units.empty() && is_unit_row(fields)) {
      for (const std::string_view field : fields) layout.units.push_back(unit_in_field(field));
      continue;
    }
    if (!layout.names.empty()) groups = std::move(layout.names);
    layout.names = names_of(lines[i].text, layout);
  }
  if (!groups.empty()) add_groups(layout.names, groups);
}

/// The names in a comment directly before the rows, if there are as many.
std::vector<std::string> commented_names(std::string_view text, std::size_t offset, const TableLayout& layout) {
  const std::string_view row = text.substr(offset, std::min(text.find('\n', offset), text.size()) - offset);
  if (auto names = names_for_rows_of(text.substr(0, offset), trimmed(fields_of(row, layout).front(), " \""), layout.delimiter);
      names.size() == layout.columns)
    return names;
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

namespace {

/// Throws Error for lines that no table has.
void expect_short_lines(const std::string& file, const std::vector<Line>& lines) {
  constexpr std::size_t longest = std::size_t{1} << 20;
  for (const Line& line : lines)
    if (line.text.size() > longest)
      throw Error(fmt::format("{}:{}: is a line of {} bytes; expected rows of numbers, one a line", file, line.number, line.text.size()));
}

void expect_columns(const TableLayout& layout, std::size_t line) {
  constexpr std::size_t most = 4096;
  if (layout.columns > most)
    throw Error(fmt::format("{}: has {} fields; expected at most {}: one row of numbers a line", layout.at(line), layout.columns, most));
}

/// Throws Error where rows have twice the fields of the header and whole numbers alone: decimals behind commas that also divide the fields.
void expect_no_decimal_commas(const TableLayout& layout, const std::vector<Line>& lines, std::size_t first) {
  if (first == 0 || layout.delimiter != ',') return;
  const auto names = fields_of(lines[first - 1].text, layout), fields = fields_of(lines[first].text, layout);
  const bool whole =
      std::all_of(fields.begin(), fields.end(), [](std::string_view f) { return f.find_first_not_of("+-0123456789") == std::string_view::npos; });
  if (whole && !has_numbers(names) && names.size() > 1 && fields.size() == 2 * names.size())
    throw Error(
        fmt::format("{}: has {} fields, twice the {} of the header: decimal commas between commas; expected fields divided by semicolons or tabs, "
                    "or decimal points",
                    layout.at(lines[first].number), fields.size(), names.size()));
}

/// What the text was before it was rewritten.
void take_hints(const TextHints& hints, TableLayout& layout) {
  layout.rewritten = hints.rewritten;
  if (hints.names.size() == layout.columns) layout.names = hints.names;
  if (hints.units.size() == layout.columns) layout.units = hints.units;
  for (const std::size_t column : hints.times) {
    if (column >= layout.columns) continue;
    layout.units.resize(layout.columns);
    layout.units[column] = "s";
  }
}

}  // namespace

std::optional<TableLayout> find_layout(const std::string& file, std::string_view text, bool named, bool complete, const TextHints& hints) {
  constexpr std::size_t longest_preamble = 200;  // lines
  TableLayout layout;
  layout.file = file;
  layout.counts_elements = hints.counts_elements;
  if (text.substr(0, 4096).find('\0') != std::string_view::npos) throw Error(file + ": is not text; expected CSV or plain columns of numbers");
  const std::vector<Line> lines = content_lines(text, 0, longest_preamble);
  if (lines.empty()) return std::nullopt;
  expect_short_lines(file, lines);
  const Preamble preamble = find_preamble(lines, layout, hints.delimiter);
  const std::size_t first = preamble.lines;
  if (first > 0) layout.skipped = lines[first].number - 1;
  layout.settled = complete || preamble.known || lines.size() == longest_preamble;
  layout.delimiter = hints.delimiter != 0 ? hints.delimiter : delimiter_of(trimmed(lines[first].text));
  layout.columns = fields_of(lines[first].text, layout).size();
  expect_columns(layout, lines[first].number);
  expect_no_decimal_commas(layout, lines, first);
  const auto a_row = [&](const Line& line) { return is_row(fields_of(line.text, layout)); };
  if (complete && lines.size() > first + 1 && std::none_of(lines.begin() + static_cast<std::ptrdiff_t>(first), lines.end(), a_row))
    throw Error(file + ": has no row of numbers; expected CSV or plain columns of numbers");  // of another kind of file nothing is quoted
  const auto is_header = [&](const Line& line) {                                              // a row with one bad field is a bad row, not a header
    const auto fields = fields_of(line.text, layout);
    return fields.size() == layout.columns && !has_numbers(fields);
  };
  std::size_t row = first;
  if (is_header(lines[first])) ++row;
  const bool numbered = row == first && lines.size() > first + 1 && numbers_columns(fields_of(lines[first].text, layout)) &&
                        !numbers_columns(fields_of(lines[first + 1].text, layout));
  const auto follows_a_row = [&](std::size_t i) { return i < lines.size() && a_row(lines[i]); };
  for (std::size_t end = row + 1; row > first && end < first + longest_header + 1; ++end)  // further lines of it, where a row follows them
    if (end - 1 < lines.size() && is_header(lines[end - 1]) &&
        (follows_a_row(end) || (end < lines.size() && is_header(lines[end]) && follows_a_row(end + 1))))
      row = end;
  if (row == lines.size()) return std::nullopt;
  read_header(lines, first, row, layout);
  if (numbered) layout.header.emplace_back(trimmed(lines[row++].text));
  if (!complete && row > first && fields_of(lines[row].text, layout).size() != layout.columns)
    return std::nullopt;  // a preamble, as what follows may show
  layout.offset = lines[row].offset;
  layout.line = lines[row].number;
  if (row == first + (numbered ? 1 : 0)) layout.names = commented_names(text, layout.offset, layout);
  take_hints(hints, layout);
  if (named && layout.names.empty() && !layout.settled) return std::nullopt;
  if (named && layout.names.empty())
    throw Error(fmt::format("{}: has no header; expected one because columns are named (or give columns by number)", layout.at(layout.line)));
  return layout;
}

TableLayout table_layout(const std::string& file, std::string_view text, bool named, const TextHints& hints) {
  if (auto layout = find_layout(file, text, named, true, hints)) return *std::move(layout);
  const bool header = !content_lines(text, 0, 1).empty();  // a row would have been found
  throw Error(fmt::format("{}: {}; expected rows of numbers", file, text.empty() ? "is empty" : header ? "has a header but no rows" : "has no rows"));
}

}  // namespace imulab::recording_io
