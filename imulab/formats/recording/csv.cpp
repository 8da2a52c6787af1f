#include "imulab/formats/recording/csv.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/memory.hpp"
#include "imulab/core/parallel.hpp"
#include "imulab/formats/recording/csv_rows.hpp"
#include "imulab/formats/recording/formats.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/reading_meter.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <functional>
#include <string>
#include <utility>

namespace imulab::recording_io {
namespace {

void reserve(TimedTable& table, std::string_view rows) {
  const std::size_t estimate = rows_to_reserve(rows);
  table.time_ns.reserve(estimate);
  for (auto& column : table.values) column.reserve(estimate);
}

/// Adds all rows of a text of whole lines to a table. The meter is told after every so many rows.
void add_rows(RowReader& reader, std::string_view text, TimedTable& table, const ReadingMeter& meter) {
  constexpr std::size_t at_once = 4096;
  std::size_t told = text.size();
  while (reader.next(text)) {
    table.lines.add(table.time_ns.size(), reader.line());
    table.time_ns.push_back(reader.row().time_ns);
    for (std::size_t k = 0; k < table.values.size(); ++k) table.values[k].push_back(reader.row().values[k]);
    if (table.time_ns.size() % at_once == 0) meter.add(std::exchange(told, text.size()) - text.size());
  }
  meter.add(told);
}

/// Rows of whole lines, and how many lines they are.
TimedTable read_rows(RowReader reader, std::string_view text, const ReadingMeter& meter, std::size_t& lines) {
  TimedTable table;
  table.values.resize(reader.row().values.size());
  reserve(table, text);
  add_rows(reader, text, table, meter);
  table.repeated = reader.repeated();
  lines = reader.lines_read();
  return table;
}

/// The text in parts of whole lines.
std::vector<std::string_view> parts_of_lines(std::string_view text, std::size_t count) {
  std::vector<std::string_view> parts;
  for (std::size_t left = count; left > 1 && !text.empty(); --left) parts.push_back(take_lines(text, text.size() / left));
  if (!text.empty()) parts.push_back(text);
  return parts;
}

/// Rows that follow those of a table, whose lines count from `lines` on.
struct Part {
  TimedTable table;
  std::size_t lines = 0;
};

bool in_sequence(const std::vector<Part>& parts, std::optional<std::int64_t> last_ns) {
  for (const Part& part : parts) {
    if (part.table.time_ns.empty()) continue;
    if (last_ns && part.table.time_ns.front() <= *last_ns) return false;
    last_ns = part.table.time_ns.back();
  }
  return true;
}

/// Adds parts that are in sequence, the first line of which is the one after `lines` others.
void append(TimedTable& table, const std::vector<Part>& parts, std::size_t lines) {
  std::size_t rows = table.time_ns.size();
  for (const Part& part : parts) {
    table.lines.append(part.table.lines, rows, lines);
    table.repeated += part.table.repeated;
    lines += part.lines;
    rows += part.table.time_ns.size();
  }
  parallel_for(table.values.size() + 1, [&](std::size_t c) {
    const auto join = [&](auto& column, auto part_of) {
      if (column.capacity() < rows) column.reserve(std::max(rows, 2 * column.capacity()));
      for (const Part& part : parts) column.insert(column.end(), part_of(part.table)->begin(), part_of(part.table)->end());
    };
    if (c == table.values.size()) return join(table.time_ns, [](const TimedTable& part) { return &part.time_ns; });
    join(table.values[c], [c](const TimedTable& part) { return &part.values[c]; });
  });
}

/// Rows by several threads, where they do not depend on those before; nothing where something is wrong, which is found again in order.
std::optional<std::vector<Part>> read_in_parallel(const RowReader& reader, std::string_view text, const ReadingMeter& meter) {
  constexpr std::size_t worth_it = std::size_t{1} << 20;  // bytes: 3 ms
  const std::size_t count = std::min<std::size_t>(parallel_threads(), text.size() / worth_it);
  if (count < 2 || !reader.is_independent()) return std::nullopt;
  const std::vector<std::string_view> texts = parts_of_lines(text, count);
  std::vector<Part> parts(texts.size());
  try {
    parallel_for(texts.size(), [&](std::size_t p) { parts[p].table = read_rows(reader, texts[p], meter, parts[p].lines); });
  } catch (const Error&) {
    return std::nullopt;
  }
  return parts;
}

/// A column that is requested twice was read once.
void put_as_requested(TimedTable& table, const std::vector<std::size_t>& places) {
  std::vector<std::vector<double>> values(places.size());
  for (std::size_t i = places.size(); i-- > 0;) {
    const auto end = places.begin() + static_cast<std::ptrdiff_t>(i);
    const bool again = std::find(places.begin(), end, places[i]) != end;
    values[i] = again ? table.values[places[i]] : std::move(table.values[places[i]]);
  }
  table.values = std::move(values);
}

/// A logger that was switched off: the last line has no end, and fewer fields than the others.
bool ends_inside_a_row(std::string_view text, const TableLayout& layout) {
  const std::size_t last = text.rfind('\n') + 1;
  if (last == 0 || last == text.size() || text[last] == '#') return false;
  const std::size_t fields = fields_of(text.substr(last), layout).size();
  return text.find_first_not_of(" \t\r", last) != std::string_view::npos && fields < layout.columns;
}

std::vector<std::string> warnings_of(const std::string& file, const TableLayout& layout, bool cut) {
  std::vector<std::string> warnings;
  if (cut) warnings.push_back(file + ": ends inside a row, which is left out");
  if (layout.skipped > 0)
    warnings.push_back(fmt::format("{}: {} line{} of other text before the table passed over", file, layout.skipped, layout.skipped == 1 ? "" : "s"));
  return warnings;
}

/// Pieces of a text: by several threads as long as all is well, else in order from the first piece on in which something is not.
class PieceReader {
 public:
  PieceReader(const RowReader& first, const ReadingMeter& meter) : first_(first), reader_(first), meter_(meter) {}

  /// Adds whole lines, which follow those of the piece before, to a table.
  void read(std::string_view text, TimedTable& table) {
    const std::size_t rows = table.time_ns.size();
    const std::optional<std::vector<Part>> parts = read_in_parallel(first_, text, meter_);
    if (parts && in_sequence(*parts, any_ ? std::optional(last_.time_ns) : std::nullopt)) {
      append(table, *parts, lines_);
      for (const Part& part : *parts) lines_ += part.lines;
      in_order_ = false;
    } else {
      read_in_order(text, table);
    }
    if (table.time_ns.size() == rows) return;
    any_ = true;
    last_.time_ns = table.time_ns.back();
    last_.values.clear();
    for (const auto& column : table.values) last_.values.push_back(column.back());
  }

 private:
  void read_in_order(std::string_view text, TimedTable& table) {
    if (!in_order_) {
      reader_ = first_;
      reader_.continue_after(last_, lines_);
      in_order_ = true;
    }
    const std::size_t repeated = reader_.repeated();
    add_rows(reader_, text, table, meter_);
    table.repeated += reader_.repeated() - repeated;
    lines_ = reader_.lines_read();
  }

  const RowReader first_;
  RowReader reader_;
  const ReadingMeter& meter_;
  Row last_;
  std::size_t lines_ = 0;
  bool any_ = false, in_order_ = true;  // whether any row was read; whether reader_ stands behind the piece before
};

constexpr std::size_t bytes_of_piece = std::size_t{1} << 22;  // bytes of text: what is read in one piece

/// Adds all rows to a table, in pieces of whole lines, which leave memory as they have been read. `bytes`: how much text the table is to hold.
/// `after` each piece the table may be emptied. A column that is requested twice is read once.
void for_each_piece(const MappedFile& file, const std::string& name, const TableLayout& layout, const RowReader& reader, TimedTable& table,
                    std::size_t bytes, const std::function<void()>& after) {
  std::string_view text = file.text().substr(layout.offset);
  const bool cut = ends_inside_a_row(text, layout);
  if (cut) text = text.substr(0, text.rfind('\n') + 1);
  const ReadingMeter meter(text.size());
  PieceReader pieces(reader, meter);
  for (bool begin = true; begin || !text.empty(); begin = false) {
    table.file = name;
    if (begin) table.warnings = warnings_of(name, layout, cut);
    if (table.time_ns.empty()) {
      table.values.resize(reader.row().values.size());
      reserve(table, text.substr(0, bytes));
    }
    pieces.read(take_lines(text, bytes_of_piece), table);
    file.release(file.text().size());
    after();
  }
  give_back_freed_memory();  // of the last pieces
}

}  // namespace

bool is_text(std::string_view head) { return head.find('\0') == std::string_view::npos; }

std::size_t rows_to_reserve(std::string_view rows) {
  const std::string_view head = rows.substr(0, 1 << 16);
  const auto lines = static_cast<std::size_t>(std::count(head.begin(), head.end(), '\n')) + 1;
  return rows.size() / (head.size() / lines + 1) * 21 / 20 + 16;  // pages never touched cost nothing
}

TimedTable read_csv(const std::filesystem::path& path, const TimeSource& time, std::optional<double> rate_hz, const std::vector<Column>& columns) {
  const MappedFile file(path);
  const std::string name = input_name(path);
  const TableLayout layout = table_layout(name, file.text(), names_a_column(time, columns));
  const RowReader reader(layout, time, rate_hz, columns);
  TimedTable all;
  for_each_piece(file, name, layout, reader, all, file.text().size(), [] {});
  put_as_requested(all, reader.places());
  return all;
}

namespace {

std::vector<TableDescription> describe_text(const TableRequest& request) {
  const MappedFile file(request.file);
  const TableLayout layout = table_layout(request.file.string(), file.text(), false);
  TableDescription table;
  for (std::size_t i = 0; i < layout.columns; ++i) table.columns.push_back({layout.column_name(i)});
  const std::string_view rows = file.text().substr(layout.offset);
  table.rows = static_cast<std::size_t>(std::count(rows.begin(), rows.end(), '\n')) + !rows.ends_with('\n');
  return {table};
}

RawTable text_columns(const TableRequest& request, const std::vector<Column>& columns) {
  TimedTable table = read_csv(request.file, {.column = std::nullopt}, 1, columns);
  RawTable raw;
  raw.row = "line";
  for (auto& column : table.values) raw.columns.push_back({std::move(column), {}});
  return raw;
}

/// By the length of the first lines.
std::size_t text_rows(const TableRequest& request, const std::vector<Column>& columns) {
  const MappedFile file(request.file);
  const TableLayout layout = table_layout(request.file.string(), file.text(), names_a_column({.column = std::nullopt}, columns));
  const std::string_view rows = file.text().substr(layout.offset), head = rows.substr(0, 1 << 16);
  const auto lines = static_cast<std::size_t>(std::count(head.begin(), head.end(), '\n')) + 1;
  return rows.size() / (head.size() / lines + 1) + 1;
}

void read_text_pieces(const TableRequest& request, const TimeSource& time, std::optional<double> rate_hz, const std::vector<Column>& columns,
                      const std::function<void(TimedTable&&)>& each) {
  const MappedFile file(request.file);
  const TableLayout layout = table_layout(request.file.string(), file.text(), names_a_column(time, columns));
  const RowReader reader(layout, time, rate_hz, columns);
  TimedTable piece;
  for_each_piece(file, request.file.string(), layout, reader, piece, bytes_of_piece, [&] {
    put_as_requested(piece, reader.places());
    each(std::exchange(piece, {}));
  });
}

}  // namespace

RecordingFormat text_format() {
  return {.name = "CSV or plain columns of numbers",
          .recognizes = is_text,
          .describe = describe_text,
          .columns = text_columns,
          .read = [](const TableRequest& request, const TimeSource& time, std::optional<double> rate_hz,
                     const std::vector<Column>& columns) { return read_csv(request.file, time, rate_hz, columns); },
          .rows = text_rows,
          .read_pieces = read_text_pieces};
}

}  // namespace imulab::recording_io
