// What a format gives of a file: the tables there are, and columns as they stand in it.
#pragma once

#include "imulab/recording/session.hpp"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace imulab::recording_io {

struct ColumnDescription {
  std::string name;
  std::string unit{};  ///< as sessions name it, where the format says; else empty
};

/// Columns with one row for each sample: a bag's topic, a log's message type, variables of one length.
struct TableDescription {
  std::string name;  ///< the topic; empty where a file has but one table
  std::string type;  ///< of its messages, as the format names it; may be empty
  std::vector<ColumnDescription> columns;
  std::size_t rows = 0;
};

/// A column of one kind of number. Integers stay exact: stamps in nanoseconds do not fit a double.
struct RawColumn {
  std::vector<double> numbers;         ///< empty where the file has integers
  std::vector<std::int64_t> integers;  ///< empty where the file has floating-point numbers

  std::size_t size() const { return numbers.size() + integers.size(); }
};

struct RawTable {
  std::vector<RawColumn> columns;     ///< one for each requested, all of one length
  std::string row = "row";            ///< what messages call a row: "message"
  std::vector<std::string> warnings;  ///< what was lost, and what it means: a file that ends inside a message
};

/// The table of that name, or the only one that has columns. Throws Error that lists the tables there are.
const TableDescription& find_table(const std::vector<TableDescription>& tables, const std::string& topic, const std::string& file);
/// The index of a column, by name or number from 1. Throws Error that lists the columns there are.
std::size_t find_column(const TableDescription& table, const Column& column, const std::string& file);

}  // namespace imulab::recording_io
