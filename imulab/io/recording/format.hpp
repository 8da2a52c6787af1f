// The formats of recording files, in one table.
#pragma once

#include "imulab/io/recording/timed_table.hpp"
#include "imulab/recording/session.hpp"

#include <filesystem>
#include <string_view>
#include <vector>

namespace imulab {

/// A format. To add one: a source file of this folder that reads it, and its row in recording_formats().
struct RecordingFormat {
  std::string_view name;
  /// Whether a file is in this format, by its first bytes: 4096, or all of a shorter file.
  bool (*recognizes)(std::string_view head);
  /// Reads the stamps as `source.time` says, and the requested columns in the file's units, in the order requested; a column may be requested twice.
  /// Throws Error with file and place for a column that is not there, a value that is not finite, and stamps that do not ascend.
  recording_io::TimedTable (*read)(const std::filesystem::path& file, const RecordingSource& source, const std::vector<Column>& columns);
};

/// All formats. The first that recognizes a file reads it; text comes last, since other formats may begin like text.
const std::vector<RecordingFormat>& recording_formats();

}  // namespace imulab
