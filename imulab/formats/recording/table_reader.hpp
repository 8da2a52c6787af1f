// Tables of recording files with their stamps, as a whole or in pieces: whole is one piece.
#pragma once

#include "imulab/formats/recording/format.hpp"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace imulab::recording_io {

/// Throws MemoryError if this number of rows, and work on them that takes `factor` times as much, need more memory than allowed.
void expect_memory_for(const std::string& file, std::size_t rows, std::size_t columns, double factor);

/// The rows of a table of a file; without a name, of the longest.
std::size_t rows_of(const std::vector<TableDescription>& tables, const std::string& topic);
/// True if columns of a table can be read so that they are never in memory as a whole.
bool in_pieces(const RecordingFormat& format, const TableRequest& request, const std::vector<TableDescription>& tables,
               const std::vector<Column>& columns);

/// Columns as they are in the file, all rows, without stamps of their own.
TableRows read_columns(const TableRequest& request, const std::vector<Column>& columns, const RecordingFormat& format);
TableRows read_columns(const TableRequest& request, const std::vector<Column>& columns);

/// Calls `each` with stamped rows, piece by piece: stamps as `wanted` says, readings in the file's units, each piece with its own lines and warnings,
/// and the number of rows that were dropped in it. Throws Error with file and place for a value that is not finite and stamps that do not ascend.
void read_pieces(const TableRequest& request, const Wanted& wanted, const RecordingFormat& format, const std::function<void(TableRows&&)>& each);

/// Reads all rows in one piece. Throws MemoryError where they do not fit into memory.
TableRows read_table(const TableRequest& request, const Wanted& wanted, const std::vector<RecordingFormat>& formats = recording_formats());

/// The stamps alone, of every row of the file in its order: including those that read_table drops. Not for text.
std::vector<std::int64_t> read_stamps(const TableRequest& request, const TimeSource& time, std::optional<double> rate_hz);

}  // namespace imulab::recording_io
