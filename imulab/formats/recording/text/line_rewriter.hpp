// Lines of one dialect -> lines that RowReader reads.
#pragma once

#include "imulab/formats/recording/text/dialect.hpp"

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

namespace imulab::recording_io {

class LineRewriter {
 public:
  /// `sensor`: of interleaved rows, whose are kept; the lines of the others become empty.
  LineRewriter(Dialect dialect, std::string sensor) : dialect_(std::move(dialect)), sensor_(std::move(sensor)) {}

  /// Appends whole lines, each rewritten. A number in another convention than the dialect's gets quotes, which no reader takes for a number.
  void add(std::string_view lines, std::string& out);
  /// True if a line means the same whatever lines stand before it.
  bool is_independent() const;

 private:
  void add_line(std::string_view line, std::string& out);
  struct Taken {
    std::string_view text;
    bool more = false;  ///< fields follow
  };
  Taken take_field(std::string_view& line) const;
  bool is_of_another_sensor(std::string_view name) const;
  void add_field(std::string_view field, std::size_t index, std::string_view line, std::string& out);
  void add_moment(std::string_view field, FieldUse use, std::string_view line, std::string& out);

  Dialect dialect_;
  std::string sensor_;
  std::string_view date_{};             ///< of the field before
  bool joined_ = false;                 ///< the next field is in the number that was written
  std::int64_t day_ = 0, before_ = -1;  ///< seconds: of the midnight before a time of day, and that time
};

}  // namespace imulab::recording_io
