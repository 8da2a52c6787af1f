// CSV and plain columns of numbers, as docs/reference/recordings.md says: the text format of recordings, solutions and heights.
#pragma once

#include "imulab/formats/recording/table.hpp"
#include "imulab/session.hpp"

#include <filesystem>
#include <optional>
#include <string_view>
#include <vector>

namespace imulab::recording_io {

/// Reads the time column and `columns`, each a header name or a 1-based number. The delimiter (comma, semicolon, tab, blanks) and the header
/// are found in the file; lines that begin with # are comments. Throws Error with file, line and column for a ragged row, a field that is not a
/// finite number, time that runs backwards or does not advance between different rows, a missing column, and a file without rows.
/// `rate_hz` is used for rows without stamps in seconds.
TableRows read_csv(const std::filesystem::path& path, const TimeSource& time, std::optional<double> rate_hz, const std::vector<Column>& columns);

/// The approximate number of rows of a text, by the length of its first lines.
std::size_t approximate_rows(std::string_view rows);
/// The number of rows for which a table reserves memory before it reads a text: some more.
std::size_t rows_to_reserve(std::string_view rows);

}  // namespace imulab::recording_io
