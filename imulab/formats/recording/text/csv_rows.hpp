// Rows of a text table, one after the other: the same for a mapped file and for a stream.
#pragma once

#include "imulab/formats/recording/text/csv_layout.hpp"
#include "imulab/recording/clock.hpp"
#include "imulab/session.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace imulab::recording_io {

struct Row {
  std::int64_t stamp = 0, fraction = 0;  ///< as a clock takes them
  std::int64_t time_ns = 0;              ///< less the zero
  std::vector<double> values;
};

/// The use of each field of a row.
struct RowPlan {
  TableLayout layout;
  std::vector<int> fields;
  int exponent = 9, fraction_exponent = 0;
};

/// Lines that are no rows and do not hurt, by kind; lines count from the first row on, which is 0.
struct LeftOutRows {
  struct Kind {
    std::size_t count = 0, line = 0;  ///< of the first
    std::string cause{};              ///< of the first
    void add(std::size_t at, std::string why);
  };
  Kind headers;     ///< the header again, of a logger that was started again
  Kind empty;       ///< rows without a value, as spreadsheets have them at the end
  Kind not_finite;  ///< rows in which a number is missing or nan
  Kind tail;        ///< text behind the last row

  /// Those of the lines that follow, the first of which is `line`.
  void append(const LeftOutRows& next, std::size_t line);
  /// What was left out, and what that means. Throws Error with the first where more are not finite than one row in a hundred.
  std::vector<std::string> warnings(const TableLayout& layout, std::size_t rows) const;
};

/// Takes whole lines with at least this number of bytes off the front of a text; all of it if it has fewer.
std::string_view take_lines(std::string_view& text, std::size_t bytes);

class RowReader {
 public:
  /// `columns` are what is read beside the time; one may be asked for twice, and is then read once. Throws Error for a column that is not there.
  /// `rate_hz`: of rows without stamps in seconds.
  RowReader(TableLayout layout, const TimeSource& time, std::optional<double> rate_hz, const std::vector<Column>& columns);

  /// Reads the next row, taking it and what stands before it off the front of `text`, which holds whole lines; false where there is none.
  /// Comments, empty lines, rows equal to the one before and those of left_out() are passed over. Throws Error with file, line and column for what is
  /// no such row.
  bool next(std::string_view& text);
  const Row& row() const { return row_; }
  /// From now on nothing is left out (all), or no more than one row in a hundred of those read so far (of a stream, whose end is not known).
  enum class Leaves { any, few, none };
  void limit_left_out(Leaves leaves) { leaves_ = leaves; }
  const LeftOutRows& left_out() const { return left_out_; }
  std::vector<std::string> left_out_warnings() const { return left_out_.warnings(plan_.layout, 100 * rows_); }
  void forget_left_out() { left_out_ = {}; }
  /// True if a line is a row.
  bool reads(std::string_view line);
  /// As if `lines` more lines had been read, the last row of which is that of another reader; where a row is independent.
  void continue_after(const Row& last, std::size_t lines);
  /// True if a row means the same whatever rows stand before it: its time is in it.
  bool is_independent() const { return stamped_ && clock_.is_independent(); }
  std::size_t lines_read() const { return next_line_ - plan_.layout.line; }
  std::size_t line() const { return line_; }          ///< of row()
  std::size_t repeated() const { return repeated_; }  ///< rows passed over because they equal the one before
  /// For each column asked for, its place in row().values.
  const std::vector<std::size_t>& places() const { return places_; }

 private:
  bool stamp();
  void leave_out(std::string_view line);

  RowPlan plan_;
  Clock clock_;
  std::vector<std::size_t> places_;
  Row row_, next_;
  bool any_ = false, stamped_ = true;
  std::size_t line_ = 0, next_line_ = 1, repeated_ = 0, rows_ = 0;
  Leaves leaves_ = Leaves::any;
  LeftOutRows left_out_;
};

}  // namespace imulab::recording_io
