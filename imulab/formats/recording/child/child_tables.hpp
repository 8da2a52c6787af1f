// Tables that a child process reads.
#pragma once

#include "imulab/formats/recording/child/child.hpp"
#include "imulab/formats/recording/logs/binary.hpp"
#include "imulab/formats/recording/table.hpp"

#include <cstddef>
#include <functional>
#include <vector>

namespace imulab::recording_io {

/// What a child sends by send_tables. Throws Error as run_in_child does.
std::vector<TableDescription> describe_in_child(const ChildTask& task, const StartChild& start);
/// The child's answer.
void send_tables(ToParent& to, const std::vector<TableDescription>& tables);

/// The columns that a child sends by a column_sender, all at last of the one length that it states. Throws Error as run_in_child does, also where
/// they are not.
TableRows columns_in_child(const ChildTask& task, std::size_t columns, const StartChild& start);
/// Sends some more rows of a column: its index, the numbers, and how many rows there are in all.
using SendColumn = std::function<void(std::size_t, const RawColumn&, std::size_t)>;
SendColumn column_sender(ToParent& to);

/// Which columns the fields of an array are.
struct SendRows {
  const SendColumn& column;
  const std::vector<std::size_t>& to;  ///< one for each field
  std::size_t rows = 0;                ///< of the array
};
/// Sends `count` rows, `stride` bytes apart.
void send_rows(const std::vector<NumberField>& fields, const char* first, std::size_t stride, std::size_t count, const SendRows& send);

}  // namespace imulab::recording_io
