// Binary numbers as they stand in files, and columns of them, for all formats that store rows of numbers.
#pragma once

#include "imulab/formats/recording/table.hpp"
#include "imulab/formats/text/reading_meter.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace imulab::recording_io {

/// The number at `p`: least significant byte first, or last where `big_endian`.
template <class T>
T load(const char* p, bool big_endian = false) {
  std::array<char, sizeof(T)> bytes;
  std::memcpy(bytes.data(), p, sizeof(T));
  if (big_endian != (std::endian::native == std::endian::big)) std::reverse(bytes.begin(), bytes.end());
  return std::bit_cast<T>(bytes);
}

template <class T>
void store(char* p, std::type_identity_t<T> value, bool big_endian = false) {
  const T stored = load<T>(reinterpret_cast<const char*>(&value), big_endian);
  std::memcpy(p, &stored, sizeof stored);
}

/// At the end of a text, least significant byte first.
template <class T>
void append(std::string& out, std::type_identity_t<T> value) {
  char bytes[sizeof(T)];
  store<T>(bytes, value);
  out.append(bytes, sizeof bytes);
}

/// CRC-32 (ISO-HDLC): of more bytes after those of `before`.
std::uint32_t crc32(std::string_view bytes, std::uint32_t before = 0);

/// The stored form of a number.
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

/// Bytes of a log that are no messages.
struct MessageLosses {
  std::size_t skipped = 0, unfinished = 0;
  void add_warnings(const std::string& file, std::vector<std::string>& warnings) const;
};

/// Rows that stand one after the other, each counted.
void add_counted(ColumnBuilder& builder, const char* first, std::size_t stride, std::size_t count, const ReadingMeter& meter);

}  // namespace imulab::recording_io
