// How one row of JSON is written: the next rows of a log differ from it in numbers and strings alone, and are read by comparison.
#pragma once

#include "imulab/formats/recording/text/json_scan.hpp"

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace imulab::recording_io {

/// A scalar in its row, and its column; none where no column takes it.
struct JsonField {
  JsonScalar value;
  std::optional<std::size_t> column;
};

class JsonPattern {
 public:
  /// Of a row and its scalars in order; nothing where the columns are in another order.
  static std::optional<JsonPattern> of(std::string_view row, const std::vector<JsonField>& fields, std::size_t columns);

  /// Appends the line of the row that begins `text` and returns its length; 0, with nothing appended, where it is written in another way.
  std::size_t add_row(std::string_view text, std::string& out) const;

 private:
  struct Piece {
    std::string text{};      ///< as the file has it: keys, brackets, true, null
    std::string line{};      ///< what of it goes into the line: commas, 1 for true
    bool is_string = false;  ///< the scalar behind it
    bool kept = false;       ///< that scalar goes into the line
  };
  std::vector<Piece> pieces_;  ///< a number or a string stands behind each but the last
};

}  // namespace imulab::recording_io
