// Rows of a text table, one after the other: the same for a mapped file and for a stream.
#pragma once

#include "imulab/formats/recording/csv_layout.hpp"
#include "imulab/recording/clock.hpp"
#include "imulab/recording/session.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
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

/// Takes whole lines with at least this number of bytes off the front of a text; all of it if it has fewer.
std::string_view take_lines(std::string_view& text, std::size_t bytes);

class RowReader {
 public:
  /// `columns` are what is read beside the time; one may be asked for twice, and is then read once. Throws Error for a column that is not there.
  /// `rate_hz`: of rows without stamps in seconds.
  RowReader(TableLayout layout, const TimeSource& time, std::optional<double> rate_hz, const std::vector<Column>& columns);

  /// Reads the next row, taking it and what stands before it off the front of `text`, which holds whole lines; false where there is none.
  /// Comments, empty lines and rows equal to the one before are passed over. Throws Error with file, line and column for what is no such row.
  bool next(std::string_view& text);
  const Row& row() const { return row_; }
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

  RowPlan plan_;
  Clock clock_;
  std::vector<std::size_t> places_;
  Row row_, next_;
  bool any_ = false, stamped_ = true;
  std::size_t line_ = 0, next_line_ = 1, repeated_ = 0;
};

}  // namespace imulab::recording_io
