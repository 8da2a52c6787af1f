#include "imulab/formats/recording/text/csv.hpp"

#include "imulab/core/memory.hpp"
#include "imulab/core/parallel.hpp"
#include "imulab/error.hpp"
#include "imulab/formats/recording/format.hpp"
#include "imulab/formats/recording/text/csv_rows.hpp"
#include "imulab/formats/recording/text/encoding.hpp"
#include "imulab/formats/recording/text/plain_text.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/formats/text/reading_meter.hpp"
#include "imulab/parallel.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <string>
#include <utility>

namespace imulab::recording_io {
namespace {

void reserve(TableRows& table, std::string_view rows) {
  const std::size_t estimate = rows_to_reserve(rows);
  table.time_ns.reserve(estimate);
  for (RawColumn& column : table.columns) column.numbers.reserve(estimate);
}

/// Adds all rows of a text of whole lines to a table. The meter is told after every so many rows.
void add_rows(RowReader& reader, std::string_view text, TableRows& table, const ReadingMeter& meter) {
  constexpr std::size_t at_once = 4096;
  std::size_t told = text.size();
  while (reader.next(text)) {
    table.lines.add(table.time_ns.size(), reader.line());
    table.time_ns.push_back(reader.row().time_ns);
    for (std::size_t k = 0; k < table.columns.size(); ++k) table.columns[k].numbers.push_back(reader.row().values[k]);
    if (table.time_ns.size() % at_once == 0) meter.add(std::exchange(told, text.size()) - text.size());
  }
  meter.add(told);
}

/// Rows that follow those of a table, whose lines count from `lines` on.
struct Part {
  TableRows table;
  std::size_t lines = 0;
  LeftOutRows left_out;
};

/// Rows of whole lines.
Part read_rows(RowReader reader, std::string_view text, const ReadingMeter& meter) {
  Part part;
  TableRows& table = part.table;
  table.columns.resize(reader.row().values.size());
  reserve(table, text);
  add_rows(reader, text, table, meter);
  table.repeated = reader.repeated();
  part.lines = reader.lines_read();
  part.left_out = reader.left_out();
  return part;
}

/// The text in parts of whole lines.
std::vector<std::string_view> parts_of_lines(std::string_view text, std::size_t count) {
  std::vector<std::string_view> parts;
  for (std::size_t left = count; left > 1 && !text.empty(); --left) parts.push_back(take_lines(text, text.size() / left));
  if (!text.empty()) parts.push_back(text);
  return parts;
}

bool in_sequence(const std::vector<Part>& parts, std::optional<std::int64_t> last_ns) {
  for (const Part& part : parts) {
    if (part.table.time_ns.empty()) continue;
    if (last_ns && part.table.time_ns.front() <= *last_ns) return false;
    last_ns = part.table.time_ns.back();
  }
  return true;
}

/// Adds parts that are in sequence, the first line of which is the one after `lines` others.
void append(TableRows& table, const std::vector<Part>& parts, std::size_t lines) {
  std::size_t rows = table.time_ns.size();
  for (const Part& part : parts) {
    table.lines.append(part.table.lines, rows, lines);
    table.repeated += part.table.repeated;
    lines += part.lines;
    rows += part.table.time_ns.size();
  }
  parallel_for(table.columns.size() + 1, [&](std::size_t c) {
    const auto join = [&](auto& column, auto part_of) {
      if (column.capacity() < rows) column.reserve(std::max(rows, 2 * column.capacity()));
      for (const Part& part : parts) column.insert(column.end(), part_of(part.table)->begin(), part_of(part.table)->end());
    };
    if (c == table.columns.size()) return join(table.time_ns, [](const TableRows& part) { return &part.time_ns; });
    join(table.columns[c].numbers, [c](const TableRows& part) { return &part.columns[c].numbers; });
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
    parallel_for(texts.size(), [&](std::size_t p) { parts[p] = read_rows(reader, texts[p], meter); });
  } catch (const Error&) {
    return std::nullopt;
  }
  return parts;
}

/// A column that is requested twice was read once.
void put_as_requested(TableRows& table, const std::vector<std::size_t>& places) {
  std::vector<RawColumn> columns(places.size());
  for (std::size_t i = places.size(); i-- > 0;) {
    const auto end = places.begin() + static_cast<std::ptrdiff_t>(i);
    const bool again = std::find(places.begin(), end, places[i]) != end;
    columns[i] = again ? table.columns[places[i]] : std::move(table.columns[places[i]]);
  }
  table.columns = std::move(columns);
}

/// A logger that was switched off: the last line has no end, and fewer fields than the others.
bool ends_inside_a_row(std::string_view text, const TableLayout& layout) {
  const std::size_t last = text.rfind('\n') + 1;
  if (last == 0 || last == text.size() || text[last] == '#') return false;
  const std::size_t fields = fields_of(text.substr(last), layout).size();
  return text.find_first_not_of(" \t\r", last) != std::string_view::npos && fields < layout.columns;
}

/// Takes lines off the end that are no rows: a spreadsheet's sums. Where they are many, they stay, and are an error.
LeftOutRows::Kind take_tail(RowReader reader, std::string_view& text) {
  constexpr std::size_t most = 1000, rows_a_line = 10;
  LeftOutRows::Kind tail;
  std::size_t end = text.size(), begin = end;
  std::string_view first;
  while (end > 0 && tail.count <= most) {
    const std::size_t last = end > 1 ? text.rfind('\n', end - 2) + 1 : 0;
    const std::string_view line = text.substr(last, end - last);
    const std::size_t content = line.find_first_not_of(" \t\r\n");
    const bool is_line = content != std::string_view::npos && line[content] != '#';
    if (is_line && reader.reads(line)) break;
    if (is_line) ++tail.count, begin = last, first = line.substr(content);
    end = last;
  }
  if (tail.count == 0 || tail.count > most || tail.count * rows_a_line > approximate_rows(text.substr(0, begin))) return {};
  tail.line = static_cast<std::size_t>(std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(begin), '\n'));
  tail.cause = fmt::format("\"{}\"", excerpt(first.substr(0, first.find_last_not_of(" \t\r\n") + 1)));
  text = text.substr(0, begin);
  return tail;
}

std::vector<std::string> warnings_of(const TextFile& file, const std::string& name, const TableLayout& layout, bool cut) {
  std::vector<std::string> warnings = file.notes();
  if (cut) warnings.push_back(name + ": ends inside a row, which is left out");
  if (layout.skipped > 0)
    warnings.push_back(fmt::format("{}: {} line{} of other text before the table passed over", name, layout.skipped, layout.skipped == 1 ? "" : "s"));
  return warnings;
}

/// Pieces of a text: by several threads as long as all is well, else in order from the first piece on in which something is not.
class PieceReader {
 public:
  PieceReader(const RowReader& first, const ReadingMeter& meter) : first_(first), reader_(first), meter_(meter) {}

  const LeftOutRows& left_out() const { return left_out_; }

  /// Adds whole lines, which follow those of the piece before, to a table.
  void read(std::string_view text, TableRows& table) {
    const std::size_t rows = table.time_ns.size();
    const std::optional<std::vector<Part>> parts = read_in_parallel(first_, text, meter_);
    if (parts && in_sequence(*parts, any_ ? std::optional(last_.time_ns) : std::nullopt)) {
      append(table, *parts, lines_);
      for (const Part& part : *parts) {
        left_out_.append(part.left_out, lines_);
        lines_ += part.lines;
      }
      in_order_ = false;
    } else {
      read_in_order(text, table);
    }
    if (table.time_ns.size() == rows) return;
    any_ = true;
    last_.time_ns = table.time_ns.back();
    last_.values.clear();
    for (const RawColumn& column : table.columns) last_.values.push_back(column.numbers.back());
  }

 private:
  void read_in_order(std::string_view text, TableRows& table) {
    if (!in_order_) {
      reader_ = first_;
      reader_.continue_after(last_, lines_);
      in_order_ = true;
    }
    const std::size_t repeated = reader_.repeated();
    reader_.forget_left_out();
    add_rows(reader_, text, table, meter_);
    left_out_.append(reader_.left_out(), 0);
    table.repeated += reader_.repeated() - repeated;
    lines_ = reader_.lines_read();
  }

  const RowReader first_;
  RowReader reader_;
  const ReadingMeter& meter_;
  Row last_;
  LeftOutRows left_out_;
  std::size_t lines_ = 0;
  bool any_ = false, in_order_ = true;  // whether any row was read; whether reader_ stands behind the piece before
};

/// Throws Error that lists the sensors whose rows are interleaved, where none is named.
void expect_one_table(const TextFile& file, const TableRequest& request, const std::string& name) {
  if (file.sensors().empty() || !request.topic.empty()) return;
  std::vector<TableDescription> tables;
  for (const std::string& sensor : file.sensors()) tables.emplace_back().name = sensor;
  find_table(tables, request.topic, name);
}

constexpr std::size_t bytes_of_piece = std::size_t{1} << 22;  // bytes of text: what is read in one piece

/// Reads whole lines piece by piece, which leave memory as they have been read; without `in_pieces` they add up to one.
void read_text_table(const TableRequest& request, const Wanted& wanted, const PieceSink& sink) {
  const std::string name = input_name(request.file);
  const TextFile file(request.file, request.topic, request.layout);
  expect_one_table(file, request, name);
  const TableLayout layout = table_layout(name, file.text(), names_a_column(wanted.time, wanted.columns), file.hints());
  const RowReader reader(layout, wanted.time, wanted.rate_hz, wanted.columns);
  std::string_view text = file.text().substr(layout.offset);
  const bool cut = ends_inside_a_row(text, layout);
  if (cut) text = text.substr(0, text.rfind('\n') + 1);
  const LeftOutRows::Kind tail = take_tail(reader, text);
  const ReadingMeter meter(text.size());
  PieceReader pieces(reader, meter);
  TableRows rows;
  std::size_t rows_before = 0;
  for (bool begin = true; begin || !text.empty(); begin = false) {
    rows.file = name;
    if (begin) rows.warnings = warnings_of(file, name, layout, cut);
    if (rows.time_ns.empty()) {
      rows.columns.resize(reader.row().values.size());
      reserve(rows, wanted.in_pieces ? text.substr(0, bytes_of_piece) : text);
    }
    pieces.read(take_lines(text, bytes_of_piece), rows);
    file.release();
    if (text.empty()) {
      LeftOutRows left_out = pieces.left_out();
      left_out.tail = tail;
      for (std::string& warning : left_out.warnings(layout, rows_before + rows.time_ns.size())) rows.warnings.push_back(std::move(warning));
    }
    if (!wanted.in_pieces && !text.empty()) continue;
    rows_before += rows.time_ns.size();
    put_as_requested(rows, reader.places());
    if (!sink(std::exchange(rows, {}))) break;
  }
  give_back_freed_memory();  // of the last pieces
}

std::vector<TableDescription> describe_text(const TableRequest& request) {
  std::vector<std::string> topics = TextFile(request.file, "", request.layout, TextFile::Part::head).sensors();
  if (topics.empty()) topics.emplace_back();
  std::vector<TableDescription> tables;
  for (const std::string& topic : topics) {
    const TextFile file(request.file, topic, request.layout, TextFile::Part::head);
    const TableLayout layout = table_layout(request.file.string(), file.text(), false, file.hints());
    TableDescription& table = tables.emplace_back();
    table.name = topic;
    for (std::size_t i = 0; i < layout.columns; ++i) table.columns.push_back({layout.column_name(i), i < layout.units.size() ? layout.units[i] : ""});
    table.rows = static_cast<std::size_t>(static_cast<double>(approximate_rows(file.text().substr(layout.offset))) * file.times_as_long());
  }
  return tables;
}

}  // namespace

std::size_t approximate_rows(std::string_view rows) {
  const std::string_view head = rows.substr(0, 1 << 16);
  const auto lines = static_cast<std::size_t>(std::count(head.begin(), head.end(), '\n')) + 1;
  return rows.size() / (head.size() / lines + 1) + 1;
}

std::size_t rows_to_reserve(std::string_view rows) { return approximate_rows(rows) * 21 / 20 + 16; }  // pages never touched cost nothing

TableRows read_csv(const std::filesystem::path& path, const TimeSource& time, std::optional<double> rate_hz, const std::vector<Column>& columns) {
  TableRows all;
  read_text_table({path}, {.columns = columns, .time = time, .rate_hz = rate_hz}, [&](TableRows&& rows) {
    all = std::move(rows);
    return true;
  });
  return all;
}

RecordingFormat text_format() {
  return {.name = "CSV or plain columns of numbers",
          .recognizes = may_be_text,
          .describe = describe_text,
          .read = read_text_table,
          .in_pieces = true,
          .is_text = true};
}

}  // namespace imulab::recording_io
