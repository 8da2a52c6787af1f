// The tables of a file, and rows of a table, as a format gives them.
#pragma once

#include "imulab/error.hpp"
#include "imulab/session.hpp"

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace imulab::recording_io {

struct ColumnDescription {
  std::string name;
  std::string unit{};       ///< as sessions name it, where the format says; else empty
  bool only_whole = false;  ///< cannot be read in pieces, although the format can
};

/// Columns with one row for each sample: a bag's topic, a log's message type, variables of one length.
struct TableDescription {
  std::string name;  ///< the topic; empty where a file has but one table
  std::string type;  ///< of its messages, as the format names it; may be empty
  std::vector<ColumnDescription> columns;
  std::size_t rows = 0;                    ///< of a long text approximately
  std::vector<std::string> other_names{};  ///< by which a session may call it, too: those of its arrays

  bool has_name(const std::string& topic) const;
};

/// A column of one kind of number. Integers stay exact: stamps in nanoseconds do not fit a double.
struct RawColumn {
  std::vector<double> numbers;         ///< empty where the file has integers
  std::vector<std::int64_t> integers;  ///< empty where the file has floating-point numbers

  std::size_t size() const { return numbers.size() + integers.size(); }
  /// Integers become numbers.
  void make_numbers();
  /// Adds the rows of another one; both become numbers where one of them has numbers.
  void append(RawColumn&& next);
};

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

/// Rows of a table that follow one another: all of them, or a piece. A format gives its columns as they are in the file; the reader
/// (table_reader.hpp) adds the stamps and makes every column one of floating-point numbers.
struct TableRows {
  std::vector<RawColumn> columns;       ///< one for each requested, all of one length
  std::string row = "row";              ///< what messages call a row: "message"
  std::vector<std::string> warnings;    ///< what was lost, and what it means: a file that ends inside a message
  std::string file{};                   ///< as messages name it
  std::vector<std::int64_t> time_ns{};  ///< ascending, the clock's zero subtracted
  LineNumbers lines{};                  ///< of a text file
  std::size_t repeated = 0;             ///< rows dropped because they equal the row before
  std::size_t first = 0;                ///< of a piece of a table without lines: the number of rows before it

  std::size_t size() const { return columns.empty() ? 0 : columns.front().size(); }
  /// "line 12", or "row 5" of a file that has no lines; for messages.
  std::string place(std::size_t index) const;
};

/// The table of that name, or the only one that has columns. Throws Error that lists the tables there are.
const TableDescription& find_table(const std::vector<TableDescription>& tables, const std::string& topic, const std::string& file);
/// How a session names a column: by its name, or its number where it has none or one that would read as a sum.
Column column_named(const std::string& name, std::size_t index);
/// Of a column that is not among these names: what there is, and how a sum is written.
Error no_column(const std::string& where, const std::string& name, const std::vector<std::string>& names);
/// The index of a column, by name or number from 1. Throws Error that lists the columns there are.
std::size_t find_column(const TableDescription& table, const Column& column, const std::string& file);

}  // namespace imulab::recording_io
