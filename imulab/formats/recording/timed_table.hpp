// The common form of all recording formats: a time column and columns of numbers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace imulab::recording_io {

/// The line of each row, kept only where it does not simply follow the row before.
class LineNumbers {
 public:
  void add(std::size_t row, std::size_t line) {
    if (jumps_.empty() || line - row != jumps_.back().second - jumps_.back().first) jumps_.emplace_back(row, line);
  }
  /// The lines of rows that follow from `row` on, which count from `line` on.
  void append(const LineNumbers& next, std::size_t row, std::size_t line);
  /// 0 where no line is known.
  std::size_t operator[](std::size_t row) const;

 private:
  std::vector<std::pair<std::size_t, std::size_t>> jumps_;  // row, line
};

struct TimedTable {
  std::string file;                         ///< as messages name it
  std::vector<std::int64_t> time_ns;        ///< ascending, the clock's zero subtracted
  std::vector<std::vector<double>> values;  ///< one column for each requested, as long as time_ns; all finite
  LineNumbers lines;                        ///< of a text file
  std::size_t repeated = 0;                 ///< rows dropped because they equal the row before
  std::size_t first = 0;                    ///< of a piece of a table without lines: how many rows stand before it
  std::string row = "row";                  ///< what a row is called in a file that has no lines
  std::vector<std::string> warnings;        ///< of reading

  /// "line 12", or "row 5" of a file that has no lines; for messages.
  std::string place(std::size_t index) const;
};

}  // namespace imulab::recording_io
