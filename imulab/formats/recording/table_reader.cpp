#include "imulab/formats/recording/table_reader.hpp"

#include "imulab/core/memory.hpp"
#include "imulab/error.hpp"
#include "imulab/formats/text/decimal.hpp"
#include "imulab/formats/text/several_files.hpp"
#include "imulab/recording/clock.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace imulab::recording_io {
namespace {

std::optional<std::int64_t> scaled(const RawColumn& column, std::size_t row, int exponent) {
  return column.integers.empty() ? scaled_stamp(column.numbers[row], exponent) : scaled_stamp(column.integers[row], exponent);
}

/// Gives pieces of a table their stamps, whose columns stand behind `before` others.
class Stamper {
 public:
  Stamper(const TableRequest& request, const TimeSource& time, std::optional<double> rate_hz, std::size_t before)
      : file_(request.topic.empty() ? request.file.string() : fmt::format("{}: {}", request.file.string(), request.topic)),
        clock_(time, rate_hz),
        before_(before),
        stamped_(time.column),
        has_fraction_(time.column && time.fraction_column) {}

  void stamp(TableRows& piece) {
    piece.file = file_;
    piece.first = rows_;
    const std::size_t rows = piece.size();
    piece.time_ns.reserve(rows);
    for (std::size_t i = 0; i < rows; ++i) {
      const auto ns = at(piece, i);
      if (!ns)
        throw Error(fmt::format("{}: {}: the stamp is not a time within 146 years of the clock's zero; expected one (is the unit right?)", file_,
                                piece.place(i)));
      piece.time_ns.push_back(*ns);
    }
    piece.columns.resize(before_);
    rows_ += rows;
  }
  void expect_rows() const {
    if (rows_ == 0) throw Error(file_ + ": has no rows; expected samples");
  }

 private:
  std::optional<std::int64_t> at(const TableRows& piece, std::size_t row) {
    if (!stamped_) return clock_.next();
    const auto stamp = scaled(piece.columns[before_], row, clock_.exponent());
    const auto fraction = has_fraction_ ? scaled(piece.columns[before_ + 1], row, clock_.fraction_exponent()) : 0;
    return stamp && fraction ? clock_.next(*stamp, *fraction) : std::nullopt;
  }

  std::string file_;
  Clock clock_;
  std::size_t before_, rows_ = 0;
  bool stamped_, has_fraction_;
};

std::string column_text(const Column& column) {
  const std::string* name = std::get_if<std::string>(&column);
  return name != nullptr ? *name : fmt::format("column {}", std::get<int>(column));
}

void expect_finite(const TableRows& piece, const std::vector<Column>& columns) {
  for (std::size_t c = 0; c < piece.columns.size(); ++c) {
    const std::vector<double>& numbers = piece.columns[c].numbers;
    for (std::size_t i = 0; i < numbers.size(); ++i)
      if (!std::isfinite(numbers[i]))
        throw Error(fmt::format("{}: {}: {}: {} is not a reading; expected a finite number", piece.file, piece.place(i), column_text(columns[c]),
                                numbers[i]));
  }
}

/// Takes out the rows that equal the row before, which may be in the piece before. Throws Error where time does not ascend otherwise.
class Ascending {
 public:
  void expect_in(TableRows& piece) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < piece.time_ns.size(); ++i) {
      const std::optional<std::int64_t> before = kept > 0 ? piece.time_ns[kept - 1] : last_ns_;
      if (before && piece.time_ns[i] <= *before) {
        expect_same(piece, i, *before, kept);
        ++piece.repeated;
        continue;
      }
      if (const std::size_t to = kept++; to != i) {
        piece.time_ns[to] = piece.time_ns[i];
        for (RawColumn& column : piece.columns) column.numbers[to] = column.numbers[i];
      }
    }
    piece.time_ns.resize(kept);
    for (RawColumn& column : piece.columns) column.numbers.resize(kept);
    if (kept == 0) return;
    last_ns_ = piece.time_ns.back();
    last_.clear();
    for (const RawColumn& column : piece.columns) last_.push_back(column.numbers.back());
  }

 private:
  void expect_same(const TableRows& piece, std::size_t i, std::int64_t before, std::size_t kept) const {
    if (piece.time_ns[i] < before)
      throw Error(fmt::format("{}: {}: time runs backwards: {} s after {} s; expected ascending times", piece.file, piece.place(i),
                              text::seconds_text(piece.time_ns[i]), text::seconds_text(before)));
    for (std::size_t c = 0; c < piece.columns.size(); ++c)
      if (const std::vector<double>& numbers = piece.columns[c].numbers; numbers[i] != (kept > 0 ? numbers[kept - 1] : last_[c]))
        throw Error(fmt::format("{}: {}: {} s is on two rows with different readings; expected one row for each time; {}", piece.file, piece.place(i),
                                text::seconds_text(piece.time_ns[i]), even_rows_advice()));
  }

  std::optional<std::int64_t> last_ns_;  // of the piece before
  std::vector<double> last_;
};

/// The columns and, behind them, those of time.
std::vector<Column> columns_and_time(std::vector<Column> columns, const TimeSource& time) {
  if (time.column) columns.push_back(*time.column);
  if (time.column && time.fraction_column) columns.push_back(*time.fraction_column);
  return columns;
}

/// A file that is far smaller than the memory fits into it: a row of short integers, or of digits, is at most so many times as large as numbers.
bool may_be_too_large(const TableRequest& request) {
  constexpr double most_expanded = 8;
  return most_expanded * static_cast<double>(bytes_of(request.file)) >= static_cast<double>(memory_limit());
}

}  // namespace

void expect_memory_for(const std::string& file, std::size_t rows, std::size_t columns, double factor) {
  const auto count = static_cast<double>(rows);
  expect_memory(8 * factor * count * static_cast<double>(columns),
                fmt::format("{}: reading {:.3g} million rows of {} columns", file, 1e-6 * count, columns));
}

std::size_t rows_of(const std::vector<TableDescription>& tables, const std::string& topic) {
  std::size_t rows = 0;
  for (const TableDescription& table : tables)
    if (topic.empty() || table.has_name(topic)) rows = std::max(rows, table.rows);
  return rows;
}

bool in_pieces(const RecordingFormat& format, const TableRequest& request, const std::vector<TableDescription>& tables,
               const std::vector<Column>& columns) {
  if (!format.in_pieces || format.is_text) return format.in_pieces;
  const std::string file = request.file.string();
  const TableDescription& table = find_table(tables, request.topic, file);
  return std::none_of(columns.begin(), columns.end(),
                      [&](const Column& column) { return table.columns[find_column(table, column, file)].only_whole; });
}

TableRows read_columns(const TableRequest& request, const std::vector<Column>& columns, const RecordingFormat& format) {
  TableRows all;
  format.read(request, {.columns = columns}, [&](TableRows&& rows) {
    all = std::move(rows);
    return true;
  });
  return all;
}

TableRows read_columns(const TableRequest& request, const std::vector<Column>& columns) { return read_columns(request, columns, format_of(request)); }

void read_pieces(const TableRequest& request, const Wanted& wanted, const RecordingFormat& format, const std::function<void(TableRows&&)>& each) {
  const auto pass_on = [&](TableRows&& piece) {
    each(std::move(piece));
    return true;
  };
  if (format.is_text) return format.read(request, wanted, pass_on);
  Stamper stamper(request, wanted.time, wanted.rate_hz, wanted.columns.size());
  Ascending ascending;
  format.read(request, {.columns = columns_and_time(wanted.columns, wanted.time), .in_pieces = wanted.in_pieces}, [&](TableRows&& piece) {
    stamper.stamp(piece);
    for (RawColumn& column : piece.columns) column.make_numbers();
    expect_finite(piece, wanted.columns);
    ascending.expect_in(piece);
    return pass_on(std::move(piece));
  });
  stamper.expect_rows();
}

TableRows read_table(const TableRequest& request, const Wanted& wanted, const std::vector<RecordingFormat>& formats) {
  const RecordingFormat& format = format_of(request, formats);
  constexpr double with_rests = 1.2;  // what finds them
  if (may_be_too_large(request))
    expect_memory_for(request.file.string(), rows_of(format.describe(request), request.topic), wanted.columns.size() + 1, with_rests);
  TableRows all;
  read_pieces(request, wanted, format, [&](TableRows&& rows) { all = std::move(rows); });
  return all;
}

std::vector<std::int64_t> read_stamps(const TableRequest& request, const TimeSource& time, std::optional<double> rate_hz) {
  const std::vector<Column> first = time.column ? std::vector<Column>{} : std::vector<Column>{1};  // for the number of rows
  Stamper stamper(request, time, rate_hz, first.size());
  TableRows rows = read_columns(request, columns_and_time(first, time));
  stamper.stamp(rows);
  stamper.expect_rows();
  return std::move(rows.time_ns);
}

}  // namespace imulab::recording_io
