#include "imulab/formats/recording/text/text_signals.hpp"

#include "imulab/core/text.hpp"
#include "imulab/error.hpp"
#include "imulab/formats/recording/imu_tables.hpp"
#include "imulab/formats/recording/table_reader.hpp"
#include "imulab/formats/recording/text/csv.hpp"
#include "imulab/formats/recording/text/csv_layout.hpp"
#include "imulab/formats/recording/text/csv_rows.hpp"
#include "imulab/formats/recording/text/plain_text.hpp"
#include "imulab/formats/text/decimal.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/formats/text/reading_meter.hpp"
#include "imulab/formats/text/take_until.hpp"
#include "imulab/inspection/names.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <utility>

namespace imulab::recording_io {
namespace {

double number_in(std::string_view field) {
  field = text::without_plus(field);
  double value = 0;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  return error == std::errc() && end == field.data() + field.size() ? value : std::numeric_limits<double>::quiet_NaN();
}

std::string delimiter_name(char delimiter) {
  switch (delimiter) {
    case ',':
      return "comma";
    case ';':
      return "semicolon";
    case '\t':
      return "tab";
    case '|':
      return "vertical bar";
    default:
      return "blanks";
  }
}

/// The lines of a text that hold about so many numbers.
std::string_view first_lines(const std::string& name, const TextFile& file, std::size_t most_numbers) {
  const std::string_view text = file.text();
  constexpr std::size_t shortest_number = 2;  // with what divides it from the next
  if (text.size() / shortest_number <= most_numbers) return text;
  const TableLayout layout = table_layout(name, text, false, file.hints());
  const std::string_view head = text.substr(layout.offset, 1 << 16);
  const auto lines = static_cast<std::size_t>(std::count(head.begin(), head.end(), '\n')) + 1;
  const double bytes = static_cast<double>(head.size()) / static_cast<double>(lines * layout.columns) * static_cast<double>(most_numbers);
  if (static_cast<double>(layout.offset) + bytes >= static_cast<double>(text.size())) return text;
  const std::size_t end = text.find('\n', layout.offset + static_cast<std::size_t>(bytes / part_of_long));
  return text.substr(0, end == std::string_view::npos ? text.size() : end + 1);
}

/// Where every row is one of numbers. Calls `passed` now and then: what was read so far is not needed any more.
bool read_numbers(const TableLayout& layout, std::string_view text, SignalTable& table, const std::function<void()>& passed) {
  constexpr std::size_t at_once = std::size_t{1} << 22;  // bytes
  std::vector<Column> columns;
  for (std::size_t i = 0; i < layout.columns; ++i) columns.emplace_back(static_cast<int>(i) + 1);
  try {
    RowReader reader(layout, {.column = std::nullopt}, 1, columns);
    reader.limit_left_out(RowReader::Leaves::none);
    const ReadingMeter meter(text.size());
    for (Signal& signal : table.signals) signal.values.reserve(rows_to_reserve(text.substr(layout.offset)));
    for (std::string_view left = text.substr(layout.offset); !left.empty();) {
      std::string_view rows = take_lines(left, at_once);
      meter.add(rows.size());
      while (reader.next(rows))
        for (std::size_t i = 0; i < layout.columns; ++i) table.signals[i].values.push_back(reader.row().values[i]);
      passed();
    }
    return true;
  } catch (const Error&) {
    for (Signal& signal : table.signals) signal.values.clear();
    return false;
  }
}

/// Takes out the few rows in which a column of numbers has none: at most one in a hundred, and of a short text a few at its end.
void leave_out_incomplete(SignalTable& table, const LineNumbers& lines) {
  constexpr std::size_t rows_a_row = 100, few = 10;
  const std::size_t rows = table.rows();
  std::vector<bool> incomplete(rows);
  for (const Signal& signal : table.signals) {
    const auto is_hole = [](double v) { return !std::isfinite(v); };
    const auto holes = static_cast<std::size_t>(std::count_if(signal.values.begin(), signal.values.end(), is_hole));
    if (holes > std::max(rows / rows_a_row, std::min(few, rows / few))) continue;  // no column of numbers
    for (std::size_t i = 0; holes > 0 && i < rows; ++i) incomplete[i] = incomplete[i] || is_hole(signal.values[i]);
  }
  const auto count = static_cast<std::size_t>(std::count(incomplete.begin(), incomplete.end(), true));
  const auto first = static_cast<std::size_t>(std::find(incomplete.begin(), incomplete.end(), true) - incomplete.begin());
  std::size_t behind = 0;  // at the end
  while (behind < count && incomplete[rows - 1 - behind]) ++behind;
  if (count == 0 || count - behind > rows / rows_a_row || behind > std::max(few, rows / rows_a_row)) return;
  for (Signal& signal : table.signals) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < rows; ++i)
      if (!incomplete[i]) signal.values[kept++] = signal.values[i];
    signal.values.resize(kept);
  }
  table.notes.push_back(
      fmt::format("{} row{} in which a number is missing left out, the first in line {}", count, count == 1 ? "" : "s", lines[first]));
}

/// A header of its own: no numbers, and columns of a sensor.
bool begins_another_table(const std::vector<std::string_view>& fields) {
  std::size_t axes = 0;
  for (const std::string_view field : fields) {
    if (!field.empty() && (std::isdigit(static_cast<unsigned char>(field.front())) != 0 || std::isfinite(number_in(field)))) return false;
    axes += inspection::hint_of(field).axis >= 0;
  }
  return axes >= 3;
}

[[noreturn]] void fail_at_second_header(const std::string& where, std::string_view header) {
  throw Error(fmt::format("{}: {}: begins another table; expected one in a file: cut the file before this line, and give both parts", where,
                          excerpt(header)));
}

/// What of the first rows is no number; where numbers are in it, the rows have a form that is not known here, and are shown.
void add_unread(const TableLayout& layout, std::string_view rows, SignalTable& table) {
  constexpr std::size_t shown = 3;
  std::vector<std::string_view> lines;
  for (std::string_view left = rows.substr(layout.offset); lines.size() < shown && !left.empty();)
    lines.push_back(trimmed(text::take_until(left, '\n')));
  const std::vector<std::string_view> fields = lines.empty() ? std::vector<std::string_view>{} : fields_of(lines.front(), layout);
  const auto digit = [](char c) { return c >= '0' && c <= '9'; };
  bool known = true;
  for (std::size_t i = 0; i < std::min(layout.columns, fields.size()) && !table.signals[i].values.empty(); ++i) {
    if (fields[i].empty() || std::isfinite(number_in(fields[i]))) continue;
    table.notes.push_back(fmt::format("column {}: \"{}\" is no number: such columns are not used", i + 1, excerpt(fields[i])));
    const std::size_t point = fields[i].find('.');
    known = known && !(point != std::string_view::npos && point > 0 && digit(fields[i][point - 1]) && point + 1 < fields[i].size() &&
                       digit(fields[i][point + 1]));
  }
  for (std::size_t k = 0; k < lines.size() && !known; ++k)
    table.notes.push_back(
        fmt::format("{}: {}{}", layout.at(layout.line + k), excerpt(lines[k], 100),
                    k + 1 < lines.size() ? "" : ": has numbers in a form that is not known here; expected them between delimiters"));
}

/// Fields that are no numbers become NaN; rows of another length and headers among the rows are left out.
void read_what_there_is(const TableLayout& layout, std::string_view text, SignalTable& table) {
  std::size_t ragged = 0, first_ragged = 0, number = layout.line;
  LineNumbers lines;
  const ReadingMeter meter(text.size());
  for (std::size_t offset = layout.offset; offset < text.size(); ++number) {
    const std::size_t end = std::min(text.find('\n', offset), text.size());
    const std::string_view line = text.substr(offset, end - offset);
    meter.add(line.size() + 1);
    offset = end + 1;
    const std::size_t first = line.find_first_not_of(" \t\r");
    if (first == std::string_view::npos || line[first] == '#') continue;
    const std::string_view content = line.substr(first, line.find_last_not_of(" \t\r") + 1 - first);
    if (std::find(layout.header.begin(), layout.header.end(), content) != layout.header.end()) continue;
    const std::vector<std::string_view> fields = fields_of(line, layout);
    if (begins_another_table(fields)) fail_at_second_header(layout.at(number), content);
    if (std::all_of(fields.begin(), fields.end(), [](std::string_view field) { return field.empty(); })) continue;
    if (fields.size() != layout.columns) {
      if (ragged++ == 0) first_ragged = number;
      continue;
    }
    lines.add(table.rows(), number);
    for (std::size_t i = 0; i < fields.size(); ++i) table.signals[i].values.push_back(number_in(fields[i]));
  }
  if (ragged > 0)
    table.notes.push_back(fmt::format("{} line{} do not have {} fields, the first is line {}; in the middle of the file they are an error", ragged,
                                      ragged == 1 ? "" : "s", layout.columns, first_ragged));
  if (const std::size_t rows = table.rows(); rows > 0 && lines[rows - 1] == lines[0] + rows - 1) table.first_line = lines[0];
  leave_out_incomplete(table, lines);
  add_unread(layout, text, table);
}

/// The columns of a plain text, or of its first lines.
SignalTable signals_of_plain(const std::string& name, std::string_view text, const TextFile& file, const std::string& topic,
                             const std::function<void()>& passed) {
  const TableLayout layout = table_layout(name, text, false, file.hints());
  SignalTable table;
  table.file = name;
  table.topic = topic;
  table.format = fmt::format("text, divided by {}, {} columns, {}{}{}", delimiter_name(layout.delimiter), layout.columns,
                             layout.names.empty() ? "no header" : "with a header",
                             layout.skipped > 0 ? fmt::format(", after {} lines of other text", layout.skipped) : "", file.hints().words);
  if (!topic.empty()) table.format += ", rows of " + topic;
  table.notes = file.notes();
  table.signals.resize(layout.columns);
  std::map<std::string_view, std::size_t> counts;
  for (const std::string& column : layout.names) ++counts[column];
  for (std::size_t i = 0; i < layout.columns; ++i) {
    Signal& signal = table.signals[i];
    const std::string own = i < layout.names.size() ? layout.names[i] : "";
    signal.name = topic.empty() || own.empty() ? own : name_in_table(topic, own);
    if (i < layout.units.size()) signal.unit = layout.units[i];
    signal.column = column_named(counts[own] == 1 ? own : "", i);
  }
  if (!read_numbers(layout, text, table, passed)) read_what_there_is(layout, text, table);
  return table;
}

/// The tables of a text that are read: that of the topic, or of interleaved sensors, each of which is one, those of an IMU.
ImuTables topics_of_text(const std::string& name, const TextFile& file, const std::string& topic) {
  if (file.sensors().empty() || !topic.empty()) return {{topic}, {}};
  const TableLayout layout = table_layout(name, file.text(), false, file.hints());
  std::vector<TableDescription> tables;
  for (const std::string& sensor : file.sensors()) {
    TableDescription& table = tables.emplace_back();
    table.name = sensor;
    table.rows = 1;  // whichever has more of them is the sensor of the higher rate
    for (const std::string& column : names_for_rows_of(file.text(), sensor, layout.delimiter)) table.columns.push_back({column});
    const bool named = !table.columns.empty();
    for (std::size_t i = 0; i < layout.columns && !named; ++i) table.columns.push_back({layout.column_name(i)});
  }
  return imu_tables(text_format(), {.file = name}, tables);
}

void add_notes(std::vector<SignalTable>& tables, const ImuTables& topics) {
  if (!tables.empty()) tables.front().notes.insert(tables.front().notes.end(), topics.notes.begin(), topics.notes.end());
}

SignalTable table_of_file(const std::filesystem::path& path, const std::string& topic, const std::string& layout, std::size_t most_numbers) {
  const std::string name = input_name(path);
  const TextFile file(path, topic, layout);
  const std::string_view head = first_lines(name, file, most_numbers);
  const bool whole = head.size() == file.text().size();
  if (whole) {
    const TableLayout found = table_layout(name, head, false, file.hints());
    expect_memory_for(name, approximate_rows(head.substr(found.offset)), found.columns, with_inspection);
  }
  SignalTable table = signals_of_plain(name, head, file, topic, [&] { file.release(); });
  if (!whole && !table.signals.empty()) table.notes.push_back(head_note(table.signals.front().values.size()));
  return table;
}

}  // namespace

std::string head_note(std::size_t rows) { return fmt::format("the first {} rows were looked at", rows); }

std::vector<SignalTable> tables_of_bytes(const std::string& name, std::string_view bytes, const std::string& topic, const std::string& layout) {
  std::vector<SignalTable> tables;
  const TextFile all(bytes, {name, "", layout});
  const ImuTables topics = topics_of_text(name, all, topic);
  for (const std::string& own : topics.names) {
    if (own.empty()) return {signals_of_plain(name, all.text(), all, own, [] {})};
    const TextFile file(bytes, {name, own, layout});
    tables.push_back(signals_of_plain(name, file.text(), file, own, [] {}));
  }
  add_notes(tables, topics);
  return tables;
}

/// As far as the stream came; a line that was cut is left out.
std::vector<SignalTable> tables_of_stream(const std::filesystem::path& file, const std::string& topic, const std::string& layout, double longest_s) {
  const std::string name = input_name(file);
  StreamText stream = read_stream(file, longest_s);
  if (stream.ended) return tables_of_bytes(name, stream.text, topic, layout);
  stream.text.resize(stream.text.find_last_of('\n') + 1);  // npos + 1 is 0
  if (stream.text.empty()) throw Error(fmt::format("{}: no line in {:g} s; expected rows of numbers (--for SECONDS waits longer)", name, longest_s));
  std::vector<SignalTable> tables = tables_of_bytes(name, stream.text, topic, layout);
  tables.front().notes.push_back(
      fmt::format("{} did not end within {:g} s: what came later is not looked at (--for SECONDS looks longer)", name, longest_s));
  return tables;
}

std::vector<SignalTable> tables_of_text_file(const std::filesystem::path& file, const std::string& topic, const std::string& layout,
                                             std::size_t most_numbers) {
  std::vector<SignalTable> tables;
  const ImuTables topics =
      topic.empty() ? topics_of_text(input_name(file), TextFile(file, "", layout, TextFile::Part::head), topic) : ImuTables{{topic}, {}};
  for (const std::string& own : topics.names) tables.push_back(table_of_file(file, own, layout, most_numbers));
  add_notes(tables, topics);
  return tables;
}

}  // namespace imulab::recording_io
