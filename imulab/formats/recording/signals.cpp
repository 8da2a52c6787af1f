#include "imulab/formats/recording/signals.hpp"

#include "imulab/core/error.hpp"
#include "imulab/formats/recording/csv.hpp"
#include "imulab/formats/recording/csv_layout.hpp"
#include "imulab/formats/recording/csv_rows.hpp"
#include "imulab/formats/recording/table_reader.hpp"
#include "imulab/formats/text/decimal.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/formats/text/reading_meter.hpp"
#include "imulab/inspection/names.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace imulab {
namespace {

using namespace recording_io;

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
    default:
      return "blanks";
  }
}

/// True if three columns are named like a sensor's; with `axes`, like the three axes of one.
bool has_triad(const TableDescription& table, inspection::Role role, bool axes) {
  std::map<std::string, std::array<bool, 3>> found;  // by sensor
  std::ptrdiff_t columns = 0;
  for (const ColumnDescription& column : table.columns) {
    const inspection::NameHint hint = inspection::hint_of(column.name);
    if (hint.role != role) continue;
    ++columns;
    if (hint.axis >= 0) found[hint.sensor][static_cast<std::size_t>(hint.axis)] = true;
  }
  return axes ? std::any_of(found.begin(), found.end(),
                            [](const auto& sensor) {
                              return sensor.second == std::array{true, true, true};
                            })
              : columns >= 3;
}

std::vector<const TableDescription*> tables_with_triads(const std::vector<TableDescription>& tables, bool axes) {
  std::vector<const TableDescription*> named;
  for (const TableDescription& table : tables)
    if (has_triad(table, inspection::Role::gyro, axes) && has_triad(table, inspection::Role::accel, axes)) named.push_back(&table);
  return named;
}

/// The table that has columns named like those of an IMU. Of several, that with far the most rows: autopilots log averages and states of theirs
/// beside the readings, seldom. `others`: the tables that were not taken for that reason.
const TableDescription& table_of_imu(const std::vector<TableDescription>& tables, const std::string& topic, const std::string& file,
                                     std::vector<std::string_view>& others) {
  if (!topic.empty() || tables.size() < 2) return find_table(tables, topic, file);
  std::vector<const TableDescription*> named = tables_with_triads(tables, true);
  if (named.empty()) named = tables_with_triads(tables, false);
  std::stable_sort(named.begin(), named.end(), [](const TableDescription* a, const TableDescription* b) { return a->rows > b->rows; });
  constexpr std::size_t far_more = 10;  // two IMUs' rates differ by less
  if (named.size() == 1 || (named.size() > 1 && named[0]->rows / far_more >= named[1]->rows)) {
    for (std::size_t i = 1; i < named.size(); ++i) others.push_back(named[i]->name);
    return *named.front();
  }
  std::vector<std::string_view> names;
  for (const TableDescription& table : tables)
    if (named.empty() || std::find(named.begin(), named.end(), &table) != named.end()) names.push_back(table.name);
  throw Error(fmt::format("{}: {} both gyros and accelerometers by name; expected a topic of {}", file,
                          named.empty() ? "no table has" : "several tables have", text::listed(names)));
}

/// "PX4 ULog: sensor_combined"
std::string format_text(const RecordingFormat& format, const TableDescription& table) {
  const std::string name = table.name == table.type || table.name.starts_with(table.type + ".") ? "" : table.type;
  std::string text(format.name);
  for (const std::string& part : {name, table.name})
    if (!part.empty()) text += (text.size() == format.name.size() ? ": " : " ") + part;
  return text;
}

/// A column's name; with its table's where only that one says which sensor it is: "sensor_gyro.x".
std::string name_in_table(const TableDescription& table, const std::string& name) {
  using inspection::Role;
  const inspection::NameHint column = inspection::hint_of(name);
  const Role sensor = inspection::hint_of(table.name).role;
  const bool adds = column.role == Role::unknown && column.axis >= 0 && (sensor == Role::gyro || sensor == Role::accel);
  return adds ? table.name + "." + name : name;
}

constexpr std::size_t part_of_long = 3;  // of what may be read at once: inspection holds it three times
constexpr double with_inspection = 2.5;  // what the columns and their inspection take over the columns

std::string head_note(std::size_t rows) { return fmt::format("the first {} rows were looked at", rows); }

void append(RawColumn& to, RawColumn&& from) {
  if (to.size() == 0) {
    to = std::move(from);
    return;
  }
  if (to.integers.empty() || from.integers.empty()) {
    to.numbers.insert(to.numbers.end(), to.integers.begin(), to.integers.end());
    to.integers.clear();
    to.numbers.insert(to.numbers.end(), from.numbers.begin(), from.numbers.end());
    to.numbers.insert(to.numbers.end(), from.integers.begin(), from.integers.end());
    return;
  }
  to.integers.insert(to.integers.end(), from.integers.begin(), from.integers.end());
}

/// All rows, or the first ones.
TableRows columns_of_head(const RecordingFormat& format, const TableRequest& request, const std::vector<TableDescription>& tables,
                          const std::vector<Column>& columns, std::size_t most_numbers) {
  const std::size_t rows = rows_of(tables, request.topic), most_rows = most_numbers / std::max<std::size_t>(1, columns.size());
  if (rows <= most_rows || !in_pieces(format, request, tables, columns)) {
    expect_memory_for(request.file.string(), rows, columns.size(), with_inspection);
    return read_columns(request, columns, format);
  }
  TableRows head;
  head.columns.resize(columns.size());
  format.read(request, {.columns = columns, .in_pieces = true}, [&](TableRows&& piece) {
    head.warnings.insert(head.warnings.end(), piece.warnings.begin(), piece.warnings.end());
    for (std::size_t c = 0; c < columns.size(); ++c) append(head.columns[c], std::move(piece.columns[c]));
    return head.size() < most_rows / part_of_long;
  });
  head.warnings.push_back(head_note(head.size()));
  return head;
}

SignalTable signals_of(const RecordingFormat& format, const TableRequest& request, std::size_t most_numbers) {
  const std::string file = request.file.string();
  const std::vector<TableDescription> tables = format.describe(request);
  std::vector<std::string_view> others;
  const TableDescription& table = table_of_imu(tables, request.topic, file, others);
  SignalTable result;
  result.file = file;
  result.topic = tables.size() > 1 || !request.topic.empty() ? table.name : "";
  result.format = format_text(format, table);
  std::vector<Column> columns;
  for (std::size_t i = 0; i < table.columns.size(); ++i) {
    const std::string& name = table.columns[i].name;
    columns.push_back(name.empty() ? Column(static_cast<int>(i) + 1) : Column(name));
  }
  TableRequest own = request;
  own.topic = table.name;
  TableRows raw = columns_of_head(format, own, tables, columns, most_numbers);
  result.notes = raw.warnings;
  if (!others.empty())
    result.notes.push_back(fmt::format("{} has most rows of the tables with gyros and accelerometers and was taken; --topic takes another: {}",
                                       table.name, text::listed(others)));
  for (std::size_t i = 0; i < columns.size(); ++i) {
    Signal signal{name_in_table(table, table.columns[i].name), table.columns[i].unit, columns[i], {}};
    if (raw.columns[i].integers.empty()) {
      signal.values = std::move(raw.columns[i].numbers);
    } else {
      signal.values.assign(raw.columns[i].integers.begin(), raw.columns[i].integers.end());
    }
    result.signals.push_back(std::move(signal));
  }
  return result;
}

/// The lines of a text that hold about so many numbers.
std::string_view first_lines(const std::string& name, std::string_view text, std::size_t most_numbers) {
  constexpr std::size_t shortest_number = 2;  // with what divides it from the next
  if (text.size() / shortest_number <= most_numbers) return text;
  const TableLayout layout = table_layout(name, text, false);
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

/// Fields that are no numbers become NaN; rows of another length are left out.
void read_what_there_is(const TableLayout& layout, std::string_view text, SignalTable& table) {
  std::size_t ragged = 0;
  const ReadingMeter meter(text.size());
  for (std::size_t offset = layout.offset; offset < text.size();) {
    const std::size_t end = std::min(text.find('\n', offset), text.size());
    const std::string_view line = text.substr(offset, end - offset);
    meter.add(line.size() + 1);
    offset = end + 1;
    const std::size_t first = line.find_first_not_of(" \t\r");
    if (first == std::string_view::npos || line[first] == '#') continue;
    const std::vector<std::string_view> fields = fields_of(line, layout);
    if (fields.size() != layout.columns) {
      ++ragged;
      continue;
    }
    for (std::size_t i = 0; i < fields.size(); ++i) table.signals[i].values.push_back(number_in(fields[i]));
  }
  if (ragged > 0)
    table.notes.push_back(
        fmt::format("{} line{} do not have {} fields; in the middle of the file they are an error", ragged, ragged == 1 ? "" : "s", layout.columns));
  const std::string_view first = text.substr(layout.offset, std::min(text.find('\n', layout.offset), text.size()) - layout.offset);
  if (first.find('"') != std::string_view::npos) table.notes.push_back("numbers stand in quotes; expected them without");
  for (std::size_t i = 0; i < layout.columns && !table.signals[i].values.empty(); ++i) {
    const std::string field(i < fields_of(first, layout).size() ? fields_of(first, layout)[i] : "");
    if (std::isfinite(table.signals[i].values.front()) || field.empty() || field.front() == '"') continue;
    const bool decimal_comma = layout.delimiter != ',' && field.find(',') != std::string::npos;
    table.notes.push_back(
        fmt::format("column {}: \"{}\" is {}", i + 1, field.substr(0, 40),
                    decimal_comma ? "written with a decimal comma; expected a point" : "no number: such columns are not used (no dates)"));
  }
}

/// As far as the stream came; a line that was cut is left out.
SignalTable signals_of_stream(const std::filesystem::path& file, double longest_s) {
  const std::string name = input_name(file);
  StreamText stream = read_stream(file, longest_s);
  if (stream.ended) return signals_of_text(name, stream.text);
  stream.text.resize(stream.text.find_last_of('\n') + 1);  // npos + 1 is 0
  if (stream.text.empty()) throw Error(fmt::format("{}: no line in {:g} s; expected rows of numbers (--for SECONDS waits longer)", name, longest_s));
  SignalTable table = signals_of_text(name, stream.text);
  table.notes.push_back(fmt::format("{} did not end within {:g} s: what came later is not looked at (--for SECONDS looks longer)", name, longest_s));
  return table;
}

}  // namespace

SignalTable signals_of_text(const std::string& name, std::string_view text, const std::function<void()>& passed) {
  const TableLayout layout = table_layout(name, text, false);
  SignalTable table;
  table.file = name;
  table.format = fmt::format("text, divided by {}, {} columns, {}{}", delimiter_name(layout.delimiter), layout.columns,
                             layout.names.empty() ? "no header" : "with a header",
                             layout.skipped > 0 ? fmt::format(", after {} lines of other text", layout.skipped) : "");
  table.signals.resize(layout.columns);
  for (std::size_t i = 0; i < layout.columns; ++i) {
    Signal& signal = table.signals[i];
    signal.name = i < layout.names.size() ? layout.names[i] : "";
    const bool usable = !signal.name.empty() && std::count(layout.names.begin(), layout.names.end(), signal.name) == 1;
    signal.column = usable ? Column(signal.name) : Column(static_cast<int>(i) + 1);
  }
  if (!read_numbers(layout, text, table, passed)) read_what_there_is(layout, text, table);
  return table;
}

SignalTable read_signals(const std::filesystem::path& file, const std::string& topic, const std::vector<RecordingFormat>& formats, double longest_s,
                         std::size_t most_numbers) {
  if (is_stream(file)) return signals_of_stream(file, longest_s);
  const TableRequest request{file, topic, ""};
  const RecordingFormat& format = format_of(request, formats);
  if (!format.is_text) return signals_of(format, request, most_numbers);
  const MappedFile mapped(file);
  const std::string_view head = first_lines(input_name(file), mapped.text(), most_numbers);
  if (head.size() == mapped.text().size())
    expect_memory_for(input_name(file), format.describe(request).front().rows, table_layout(input_name(file), head, false).columns, with_inspection);
  SignalTable table = signals_of_text(input_name(file), head, [&] { mapped.release(mapped.text().size()); });
  if (head.size() < mapped.text().size() && !table.signals.empty()) table.notes.push_back(head_note(table.signals.front().values.size()));
  return table;
}

}  // namespace imulab
