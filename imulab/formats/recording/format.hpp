// The formats of recording files, in one table.
#pragma once

#include "imulab/formats/recording/raw_table.hpp"
#include "imulab/formats/recording/timed_table.hpp"
#include "imulab/recording/session.hpp"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

/// A table of a recording file.
struct TableRequest {
  std::filesystem::path file;
  std::string topic{};   ///< its name; empty: the only table of the file
  std::string layout{};  ///< of rows of binary numbers, as declared: "f8 f4x6"
};

/// A format. To add one: a source file of this folder that reads it, and its row in recording_formats().
struct RecordingFormat {
  std::string_view name;
  /// Whether a file is in this format, by its first bytes: 4096, or all of a shorter file.
  bool (*recognizes)(std::string_view head);
  /// The tables of a file, for people who have to choose among them. Throws Error where the file is damaged.
  std::vector<recording_io::TableDescription> (*describe)(const TableRequest& request);
  /// The columns of a table as they are in the file, in the order requested; a column may be requested twice. Only they are held in memory. Throws
  /// Error with file and place for a table or column that is not there (naming those that are) and for a damaged file.
  recording_io::RawTable (*columns)(const TableRequest& request, const std::vector<Column>& columns);
  /// Stamps and readings together, if the format can read them faster than by columns; else null.
  recording_io::TimedTable (*read)(const TableRequest& request, const TimeSource& time, std::optional<double> rate_hz,
                                   const std::vector<Column>& columns) = nullptr;
  /// The approximate number of rows of a table whose columns can be read in pieces, so that they are never in memory as a whole; 0 if they cannot.
  /// Throws Error as `columns` does. Null if no table can.
  std::size_t (*rows)(const TableRequest& request, const std::vector<Column>& columns) = nullptr;
  /// The same as `columns`, in pieces of neighboring rows, until `each` says false.
  void (*pieces)(const TableRequest& request, const std::vector<Column>& columns,
                 const std::function<bool(recording_io::RawTable&&)>& each) = nullptr;
  /// The same as `read`.
  void (*read_pieces)(const TableRequest& request, const TimeSource& time, std::optional<double> rate_hz, const std::vector<Column>& columns,
                      const std::function<void(recording_io::TimedTable&&)>& each) = nullptr;
  bool of_layout = false;  ///< reads files whose layout is declared, and no other
};

/// All formats. The first that recognizes a file reads it; text comes last, since other formats may begin like text.
const std::vector<RecordingFormat>& recording_formats();

/// The format of a file. Throws Error that names the formats where none is recognized.
const RecordingFormat& format_of(const TableRequest& request, const std::vector<RecordingFormat>& formats = recording_formats());

namespace recording_io {

/// Throws MemoryError if this number of rows, and work on them that takes `factor` times as much, need more memory than allowed.
void expect_memory_for(const std::string& file, std::size_t rows, std::size_t columns, double factor);

/// Reads a table with stamps as `time` says and readings in the file's units. Throws Error with file and place for a value that is not finite and
/// stamps that do not ascend.
TimedTable read_table(const TableRequest& request, const TimeSource& time, std::optional<double> rate_hz, const std::vector<Column>& columns,
                      const std::vector<RecordingFormat>& formats = recording_formats());

/// The same in pieces of neighboring rows, each with its own lines and warnings, and the number of rows that were dropped in it. Not of a format
/// without pieces.
void read_table_in_pieces(const TableRequest& request, const TimeSource& time, std::optional<double> rate_hz, const std::vector<Column>& columns,
                          const RecordingFormat& format, const std::function<void(TimedTable&&)>& each);

/// The stamps alone, of every row of the file in its order: including those that read_table drops. Not for text.
std::vector<std::int64_t> read_stamps(const TableRequest& request, const TimeSource& time, std::optional<double> rate_hz,
                                      const std::vector<RecordingFormat>& formats = recording_formats());

}  // namespace recording_io

}  // namespace imulab
