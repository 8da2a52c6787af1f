// Rows in JSON -> lines of plain text: JSON lines, an array of rows (arrays or objects), such an array in an object, an object of columns.
#pragma once

#include "imulab/formats/recording/text/json_pattern.hpp"

#include <cstddef>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace imulab::recording_io {

class JsonRows {
 public:
  enum class Shape {
    none,     ///< no JSON, or no rows in it
    lines,    ///< a value a row, one after the other
    array,    ///< of rows
    columns,  ///< an object of arrays
    more      ///< a longer text shows it
  };

  /// Looks at the beginning of a text, or at all of it.
  JsonRows(std::string file, std::string_view text, bool complete);

  Shape shape() const { return shape_; }
  /// Of the columns; empty where rows are arrays. An array in an object has numbers behind its name: "acc.1".
  const std::vector<std::string>& names() const { return names_; }
  /// True if the text cannot be read in pieces.
  bool is_whole() const { return shape_ == Shape::columns; }
  /// True if lines of the result are elements of an array, and not lines of the file.
  bool counts_elements() const { return shape_ == Shape::array || shape_ == Shape::columns; }

  /// Appends a line for each element that is complete, or for each line of the text. Throws Error with the element for what is no row of an array.
  void add(std::string_view text, bool last, std::string& out);
  /// What was left out, at the end.
  std::vector<std::string> notes() const;

 private:
  void look_at_array(std::string_view text, std::size_t place, bool complete);
  void look_at_object(std::string_view text, std::size_t place, bool complete);
  bool find_columns(std::string_view object);
  void find_names(std::string_view elements);
  void add_columns(std::string_view text, std::string& out);
  std::size_t add_elements(std::string_view text, bool last, std::string& out);
  std::size_t add_other_text(std::string_view text, std::size_t at, std::string& out);
  void add_row(std::string_view element, std::string& out);
  void remember_pattern(std::string_view element, const std::vector<JsonField>& fields);
  std::size_t add_known_row(std::string_view text, std::string& out);

  std::string file_;
  Shape shape_ = Shape::none;
  bool ended_ = false, cut_ = false;
  bool row_on_line_ = false;  ///< the line that is being written has a row
  std::size_t owed_ = 0;      ///< ends of lines that were written before they came
  std::size_t skip_ = 0;      ///< bytes before the first element
  std::size_t elements_ = 0;
  std::vector<std::string> names_;
  std::unordered_map<std::string, std::size_t> places_;  ///< of the names
  std::string rest_;                                     ///< an element that is not complete
  std::vector<JsonPattern> patterns_;                    ///< of the last elements
  std::size_t replaced_ = 0;                             ///< of the patterns, so far
  std::string unknown_;                                  ///< the first key that no column has
  std::size_t unknown_at_ = 0;
};

}  // namespace imulab::recording_io
