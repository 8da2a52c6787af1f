// Binary numbers -> columns, for all formats that store rows of them.
#pragma once

#include "imulab/formats/recording/number_bytes.hpp"
#include "imulab/formats/recording/raw_table.hpp"
#include "imulab/formats/text/reading_meter.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

namespace imulab::recording_io {

/// How a number is stored.
struct NumberType {
  char kind = 'f';        ///< 'i', 'u' or 'f', as NumPy names them
  std::size_t bytes = 8;  ///< 1, 2, 4 or 8; 'f' from 2
  bool big_endian = false;
  bool operator==(const NumberType&) const = default;
};

/// "f8", "i2" ...; nothing for what is no such type.
std::optional<NumberType> number_type(std::string_view name);

/// A number in a row.
struct NumberField {
  NumberType type;
  std::size_t offset = 0;  ///< from the row's begin, in bytes
};

/// Columns from rows anywhere in memory. A few hundred rows are gathered and converted at once: a column's loop is as fast as copying.
class ColumnBuilder {
 public:
  /// `rows`: as many as are expected; memory for them is reserved. Integers stay integers; a column of unsigned integers of eight bytes becomes
  /// numbers from its first beyond 2^63 on.
  explicit ColumnBuilder(std::vector<NumberField> fields, std::size_t rows = 0);

  /// The row has to stay where it is until flush() or 256 rows later.
  void add(const char* row) {
    rows_[gathered_++] = row;
    if (gathered_ == rows_.size()) flush();
  }
  /// As many rows as `count`, `stride` bytes apart.
  void add(const char* first, std::size_t stride, std::size_t count);
  /// Converts what was added.
  void flush();
  /// The columns so far, which the builder gives away.
  std::vector<RawColumn> take();

 private:
  std::vector<NumberField> fields_;
  std::vector<RawColumn> columns_;
  std::array<const char*, 256> rows_{};
  std::size_t gathered_ = 0;
};

/// Rows that stand one after the other, each counted.
void add_counted(ColumnBuilder& builder, const char* first, std::size_t stride, std::size_t count, const ReadingMeter& meter);

}  // namespace imulab::recording_io
