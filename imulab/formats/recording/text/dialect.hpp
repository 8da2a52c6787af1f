// How the numbers, fields and rows of a text table are written: its dialect. RowReader reads the plain one: a point before decimals, nothing between
// thousands, no quotes, numbers instead of dates, rows of one sensor. A text in another dialect is rewritten to the plain one, each line in its place
// (plain_text.hpp), so that all that reads text sees plain text, and messages name the line of the file.
#pragma once

#include "imulab/formats/text/date.hpp"

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace imulab::recording_io {

/// What is done with a field.
enum class FieldUse : unsigned char {
  number_or_text,
  date,         ///< a date with its time of day -> seconds since 1970
  date_before,  ///< a date whose time of day is in the next field -> seconds since 1970
  joined_date,  ///< the same of blanks under one name: both are one field
  time_after,   ///< that next field -> the same seconds
  time_of_day,  ///< alone -> seconds since the first midnight
  sensor        ///< the name of the sensor whose row it is
};

struct Dialect {
  char delimiter = 0;  ///< 0: not found; the layout finds it
  char decimal = '.';
  char thousands = 0;  ///< ',' '.' ' ' '\''; 0: none
  bool quotes = false;
  text::DateOrder order = text::DateOrder::unknown;
  std::vector<FieldUse> uses;        ///< of the fields; those behind the last are number_or_text
  std::vector<std::string> sensors;  ///< whose rows are interleaved; empty where one table has all rows

  bool is_plain() const { return decimal == '.' && thousands == 0 && !quotes && uses.empty(); }
  FieldUse use(std::size_t field) const { return field < uses.size() ? uses[field] : FieldUse::number_or_text; }
  /// "decimal commas, dates", for people; empty of the plain one.
  std::string words() const;
};

/// One field of a line, without quotes and the blanks around it.
struct FieldText {
  std::string_view text;
  bool quoted = false;
};
/// The fields of a line between delimiters (' ': runs of blanks); a delimiter in quotes divides nothing.
std::vector<FieldText> split_fields(std::string_view line, char delimiter);

/// What is declared of a text, where it does not show it itself: layout = "text decimal=, dates=dmy".
struct DeclaredDialect {
  std::optional<char> decimal;
  text::DateOrder order = text::DateOrder::unknown;
};
/// True if a declared layout is one of text. Throws Error for an unknown word in it.
bool is_text_layout(std::string_view layout);
DeclaredDialect declared_dialect(std::string_view layout, const std::string& file);

/// Recognizes the dialect of a text (UTF-8, lines end with \n) from its first lines; what they leave open, from the others. Throws Error with a line
/// where conventions are mixed, and where the whole text does not show which of two is meant, saying what to declare. `complete`: no more text
/// follows; without it nothing is thrown for what lines that follow may show, and nothing is returned.
std::optional<Dialect> recognize_dialect(const std::string& file, std::string_view text, bool complete, const DeclaredDialect& declared);

}  // namespace imulab::recording_io
