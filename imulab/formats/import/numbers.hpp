// Numbers in text, line by line.
#pragma once

#include "imulab/formats/import/format.hpp"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace imulab::import_io {

/// The whole text as a finite number; a leading + is allowed.
std::optional<double> finite_number(std::string_view text);

struct Line {
  int number = 0;  ///< from 1
  std::string_view text;
};
/// Without what follows a # or %, without blanks at both ends, without empty lines.
std::vector<Line> lines_of(std::string_view text);

/// Between any of `separators`.
std::vector<std::string_view> words_of(std::string_view text, std::string_view separators = " \t\r,;");

/// True if a line has `key` with a colon as YAML and JSON have keys: at its beginning, in a list or in braces, with or without quotes.
bool has_key(std::string_view text, std::string_view key);

struct Numbers {
  std::vector<double> values;
  std::vector<int> lines;  ///< of each
};
/// All numbers of a text of numbers alone; throws Error at the first word that is none, and where there are more than `most`.
Numbers numbers_of(const Source& source, std::size_t most);

/// Nine numbers, row by row.
Matrix3d matrix_from(const double* values);

}  // namespace imulab::import_io
