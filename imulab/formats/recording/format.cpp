#include "imulab/formats/recording/format.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/memory.hpp"
#include "imulab/formats/recording/bag/folder.hpp"
#include "imulab/formats/recording/bag/kinds.hpp"
#include "imulab/formats/recording/csv.hpp"
#include "imulab/formats/recording/formats.hpp"
#include "imulab/formats/text/decimal.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/recording/clock.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace imulab {

const std::vector<RecordingFormat>& recording_formats() {
  using namespace recording_io;
  static const std::vector<RecordingFormat> formats = [] {
    std::vector<RecordingFormat> all{
        numpy_format(), matlab_format(), hdf5_format(), ulog_format(), dataflash_format(), binary_rows_format(), text_format(),
    };
    for (const bag::BagKind& kind : bag::bag_kinds())
      all.insert(all.begin(), {.name = kind.name, .recognizes = kind.recognizes, .describe = bag::describe_bag, .columns = bag::bag_columns});
    return all;
  }();
  return formats;
}

const RecordingFormat& format_of(const TableRequest& request, const std::vector<RecordingFormat>& formats) {
  bag::expect_no_folder(request.file);
  if (is_stream(request.file))  // it is opened more than once
    throw Error(input_name(request.file) + ": is a pipe or a device; expected a recording that is a file on disk");
  const MappedFile mapped(request.file);
  const std::string_view head = mapped.text().substr(0, 4096);
  const auto format = std::find_if(formats.begin(), formats.end(), [&](const RecordingFormat& f) {
    return f.of_layout ? !request.layout.empty() : request.layout.empty() && f.recognizes(head);
  });
  if (format != formats.end() && is_kept(request.file) && format->recognizes != recording_io::is_text)
    throw Error(fmt::format("{}: is {}; expected rows of text, or a file on disk", request.file.string(), format->name));
  if (format != formats.end()) return *format;
  bag::expect_not_packed(request.file, head);
  std::vector<std::string_view> names;
  for (const RecordingFormat& f : formats) names.push_back(f.name);
  throw Error(fmt::format("{}: unknown format; expected {}", request.file.string(), text::listed(names)));
}

namespace recording_io {
namespace {

/// A column's number as the integer that a clock takes; nothing where it is none.
std::optional<std::int64_t> scaled(const RawColumn& column, std::size_t row, int exponent) {
  if (column.integers.empty()) return scaled_stamp(column.numbers[row], exponent);
  std::int64_t value = column.integers[row];
  for (int i = 0; i < exponent; ++i)
    if (__builtin_mul_overflow(value, 10, &value)) return std::nullopt;
  return value;
}

/// Reads stamp after stamp of a raw table, whose columns of time stand behind `before` others.
class StampReader {
 public:
  StampReader(const TimeSource& time, std::optional<double> rate_hz, std::size_t before)
      : clock_(time, rate_hz), before_(before), stamped_(time.column), has_fraction_(time.column && time.fraction_column) {}

  std::optional<std::int64_t> at(const RawTable& raw, std::size_t row) {
    if (!stamped_) return clock_.next();
    const auto stamp = scaled(raw.columns[before_], row, clock_.exponent());
    const auto fraction = has_fraction_ ? scaled(raw.columns[before_ + 1], row, clock_.fraction_exponent()) : 0;
    return stamp && fraction ? clock_.next(*stamp, *fraction) : std::nullopt;
  }

 private:
  Clock clock_;
  std::size_t before_;
  bool stamped_, has_fraction_;
};

std::vector<double> as_numbers(RawColumn column) {
  if (column.integers.empty()) return std::move(column.numbers);
  return {column.integers.begin(), column.integers.end()};
}

std::string column_text(const Column& column) {
  const std::string* name = std::get_if<std::string>(&column);
  return name != nullptr ? *name : fmt::format("column {}", std::get<int>(column));
}

void expect_finite(const TimedTable& table, const std::vector<Column>& columns) {
  for (std::size_t c = 0; c < table.values.size(); ++c)
    for (std::size_t i = 0; i < table.values[c].size(); ++i)
      if (!std::isfinite(table.values[c][i]))
        throw Error(fmt::format("{}: {}: {}: {} is not a reading; expected a finite number", table.file, table.place(i), column_text(columns[c]),
                                table.values[c][i]));
}

/// Takes out the rows that equal the row before. Throws Error where time does not ascend otherwise.
void expect_ascending(TimedTable& table) {
  const auto keep = [&](std::size_t to, std::size_t from) {
    if (to == from) return;
    table.time_ns[to] = table.time_ns[from];
    for (auto& column : table.values) column[to] = column[from];
  };
  std::size_t kept = 0;
  for (std::size_t i = 0; i < table.time_ns.size(); ++i) {
    if (kept > 0 && table.time_ns[i] <= table.time_ns[kept - 1]) {
      if (table.time_ns[i] < table.time_ns[kept - 1])
        throw Error(fmt::format("{}: {}: time runs backwards: {} s after {} s; expected ascending times", table.file, table.place(i),
                                text::seconds_text(table.time_ns[i]), text::seconds_text(table.time_ns[kept - 1])));
      const bool same = std::all_of(table.values.begin(), table.values.end(), [&](const auto& column) { return column[i] == column[kept - 1]; });
      if (!same)
        throw Error(fmt::format("{}: {}: {} s is on two rows with different readings; expected one row for each time", table.file, table.place(i),
                                text::seconds_text(table.time_ns[i])));
      ++table.repeated;
      continue;
    }
    keep(kept++, i);
  }
  table.time_ns.resize(kept);
  for (auto& column : table.values) column.resize(kept);
}

/// The columns and, behind them, those of time.
std::vector<Column> columns_and_time(std::vector<Column> columns, const TimeSource& time) {
  if (time.column) columns.push_back(*time.column);
  if (time.column && time.fraction_column) columns.push_back(*time.fraction_column);
  return columns;
}

RawTable with_time(const TableRequest& request, const TimeSource& time, const std::vector<Column>& columns, const RecordingFormat& format) {
  return format.columns(request, columns_and_time(columns, time));
}

/// Such a table's rows with their stamps, `first` rows behind its begin.
TimedTable stamped_table(const TableRequest& request, const RawTable& raw, StampReader& stamps, std::size_t first) {
  TimedTable table;
  table.file = request.topic.empty() ? request.file.string() : fmt::format("{}: {}", request.file.string(), request.topic);
  table.row = raw.row;
  table.first = first;
  table.warnings = raw.warnings;
  const std::size_t rows = raw.columns.empty() ? 0 : raw.columns.front().size();
  if (rows == 0) throw Error(table.file + ": has no rows; expected samples");
  table.time_ns.reserve(rows);
  for (std::size_t i = 0; i < rows; ++i) {
    const auto ns = stamps.at(raw, i);
    if (!ns)
      throw Error(fmt::format("{}: {}: the stamp is not a time within 146 years of the clock's zero; expected one (is the unit right?)", table.file,
                              table.place(i)));
    table.time_ns.push_back(*ns);
  }
  return table;
}

/// The last row of the piece before, put in front of a piece to be checked with it.
class LastRow {
 public:
  void put_before(TimedTable& piece) const {
    if (values_.empty()) return;
    piece.time_ns.insert(piece.time_ns.begin(), time_ns_);
    for (std::size_t c = 0; c < values_.size(); ++c) piece.values[c].insert(piece.values[c].begin(), values_[c]);
    --piece.first;
  }
  void take_off(TimedTable& piece) {
    if (!values_.empty()) {
      piece.time_ns.erase(piece.time_ns.begin());
      for (auto& column : piece.values) column.erase(column.begin());
      ++piece.first;
    }
    if (piece.time_ns.empty()) return;
    time_ns_ = piece.time_ns.back();
    values_.clear();
    for (const auto& column : piece.values) values_.push_back(column.back());
  }

 private:
  std::int64_t time_ns_ = 0;
  std::vector<double> values_;
};

TimedTable timed_table(const TableRequest& request, const TimeSource& time, std::optional<double> rate_hz, const std::vector<Column>& columns,
                       const RecordingFormat& format) {
  RawTable raw = with_time(request, time, columns, format);
  StampReader stamps(time, rate_hz, columns.size());
  TimedTable table = stamped_table(request, raw, stamps, 0);
  for (std::size_t c = 0; c < columns.size(); ++c) table.values.push_back(as_numbers(std::move(raw.columns[c])));
  expect_finite(table, columns);
  expect_ascending(table);
  return table;
}

}  // namespace

void expect_memory_for(const std::string& file, std::size_t rows, std::size_t columns, double factor) {
  const auto count = static_cast<double>(rows);
  expect_memory(8 * factor * count * static_cast<double>(columns),
                fmt::format("{}: reading {:.3g} million rows of {} columns", file, 1e-6 * count, columns));
}

namespace {

/// A file that is far smaller than the memory fits into it: a row of short integers, or of digits, is at most so many times as large as numbers.
bool may_be_too_large(const TableRequest& request) {
  constexpr double most_expanded = 8;
  std::error_code none;
  const auto bytes = static_cast<double>(std::filesystem::file_size(request.file, none));
  return !none && most_expanded * bytes >= static_cast<double>(memory_limit());
}

std::size_t rows_of(const TableRequest& request, const std::vector<Column>& columns, const RecordingFormat& format) {
  const std::size_t rows = format.rows != nullptr ? format.rows(request, columns) : 0;
  return rows > 0 ? rows : find_table(format.describe(request), request.topic, request.file.string()).rows;
}

}  // namespace

TimedTable read_table(const TableRequest& request, const TimeSource& time, std::optional<double> rate_hz, const std::vector<Column>& columns,
                      const std::vector<RecordingFormat>& formats) {
  const RecordingFormat& format = format_of(request, formats);
  constexpr double with_rests = 1.2;  // what finds them
  if (may_be_too_large(request)) expect_memory_for(request.file.string(), rows_of(request, columns, format), columns.size() + 1, with_rests);
  return format.read != nullptr ? format.read(request, time, rate_hz, columns) : timed_table(request, time, rate_hz, columns, format);
}

void read_table_in_pieces(const TableRequest& request, const TimeSource& time, std::optional<double> rate_hz, const std::vector<Column>& columns,
                          const RecordingFormat& format, const std::function<void(TimedTable&&)>& each) {
  if (format.read_pieces != nullptr) return format.read_pieces(request, time, rate_hz, columns, each);
  StampReader stamps(time, rate_hz, columns.size());
  LastRow last;
  std::size_t rows = 0;
  format.pieces(request, columns_and_time(columns, time), [&](RawTable&& raw) {
    TimedTable piece = stamped_table(request, raw, stamps, rows);
    rows += piece.time_ns.size();
    for (std::size_t c = 0; c < columns.size(); ++c) piece.values.push_back(as_numbers(std::move(raw.columns[c])));
    expect_finite(piece, columns);
    last.put_before(piece);
    expect_ascending(piece);
    last.take_off(piece);
    each(std::move(piece));
    return true;
  });
}

std::vector<std::int64_t> read_stamps(const TableRequest& request, const TimeSource& time, std::optional<double> rate_hz,
                                      const std::vector<RecordingFormat>& formats) {
  const std::vector<Column> first = time.column ? std::vector<Column>{} : std::vector<Column>{1};  // for the number of rows
  StampReader stamps(time, rate_hz, first.size());
  return stamped_table(request, with_time(request, time, first, format_of(request, formats)), stamps, 0).time_ns;
}

}  // namespace recording_io
}  // namespace imulab
