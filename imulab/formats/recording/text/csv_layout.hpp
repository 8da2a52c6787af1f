// The layout of a text table: its delimiter, its header, where its rows begin.
#pragma once

#include "imulab/session.hpp"

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace imulab::recording_io {

/// What is known of a text before its layout is looked for, since it was rewritten (plain_text.hpp).
struct TextHints {
  char delimiter = 0;              ///< 0: not known
  bool rewritten = false;          ///< a field that keeps its quotes is a number in another convention than the others
  bool counts_elements = false;    ///< a line stands for an element of an array
  std::vector<std::string> names;  ///< of the columns, where no line has them
  std::vector<std::string> units;
  std::vector<std::size_t> times;  ///< columns that were dates or times of day: they have seconds
  std::string words;               ///< for people: ", UTF-16, decimal commas"
};

struct TableLayout {
  std::string file;
  char delimiter = ' ';  ///< ',' ';' '\t', or ' ' for runs of blanks
  std::size_t columns = 0;
  std::vector<std::string> names;                   ///< of the header; empty without one
  std::vector<std::string> units;                   ///< of the columns, where a row under the header or a date says it; empty, or one for each column
  std::vector<std::string> header;                  ///< its lines, which may be repeated among the rows
  std::size_t offset = 0;                           ///< where the first row begins
  std::size_t line = 1;                             ///< its line
  std::size_t skipped = 0;                          ///< lines of other text before the header or the first row
  bool rewritten = false, counts_elements = false;  ///< as of TextHints
  bool settled = true;                              ///< false: lines that follow may show that these are such other text, too

  bool is_blank(char c) const { return c == ' ' || c == '\r' || (c == '\t' && delimiter != '\t'); }
  /// "gx" or "column 3", for messages.
  std::string column_name(std::size_t index) const;
  /// "log.csv:12", or "log.json: element 12"; for messages.
  std::string at(std::size_t line) const;
  /// Index of a column. Throws Error that lists the columns there are.
  std::size_t find(const Column& column) const;
};

/// Finds the layout in the text. `named`: columns are asked by name, so that a header is needed.
TableLayout table_layout(const std::string& file, std::string_view text, bool named, const TextHints& hints = {});
/// Finds the layout in the beginning of a text, or in a complete one; nothing where it ends before the first row.
std::optional<TableLayout> find_layout(const std::string& file, std::string_view text, bool named, bool complete, const TextHints& hints = {});
/// True if any of the columns is requested by name.
bool names_a_column(const TimeSource& time, const std::vector<Column>& columns);

/// The names in a comment that begins with that of a sensor, as its rows do: "# UncalGyro,time,x,y,z"; none where there is no such comment.
std::vector<std::string> names_for_rows_of(std::string_view lines, std::string_view sensor, char delimiter);

/// The fields of one line, without the blanks around them.
std::vector<std::string_view> fields_of(std::string_view line, const TableLayout& layout);

}  // namespace imulab::recording_io
