// Text tables of numbers with a time column: CSV and plain columns, read row by row from a mapped file.
#pragma once

#include "imulab/recording/session.hpp"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace imulab {

/// The line of each row, kept only where it does not simply follow the row before.
class LineNumbers {
 public:
  void add(std::size_t row, std::size_t line) {
    if (jumps_.empty() || line - row != jumps_.back().second - jumps_.back().first) jumps_.emplace_back(row, line);
  }
  std::size_t operator[](std::size_t row) const;

 private:
  std::vector<std::pair<std::size_t, std::size_t>> jumps_;  // row, line
};

struct TimedTable {
  std::string file;
  std::vector<std::int64_t> time_ns;        ///< ascending, less the zero
  std::vector<std::vector<double>> values;  ///< one column for each asked
  LineNumbers lines;
  std::size_t repeated = 0;  ///< rows dropped because they equal the row before
};

/// Reads the time column and `columns`, each a header name or a 1-based number. The delimiter (comma, semicolon, tab, blanks) and the header
/// are found in the file; lines that begin with # are comments. Throws Error with file, line and column for a ragged row, what is not a finite
/// number, time that runs backwards or stands still between different rows, a missing column, and a file without rows.
TimedTable read_timed_table(const std::filesystem::path& path, const TimeSource& time, const std::vector<Column>& columns);

}  // namespace imulab
