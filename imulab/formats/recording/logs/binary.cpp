#include "imulab/formats/recording/logs/binary.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <libdeflate.h>
#include <limits>
#include <utility>

namespace imulab::recording_io {

std::uint32_t crc32(std::string_view bytes, std::uint32_t before) { return libdeflate_crc32(before, bytes.data(), bytes.size()); }

namespace {

/// IEEE 754 binary16.
double half_precision(std::uint16_t bits) {
  const int exponent = (bits >> 10) & 31, fraction = bits & 1023;
  const double sign = bits >> 15 != 0 ? -1 : 1;
  if (exponent == 31) return fraction != 0 ? std::numeric_limits<double>::quiet_NaN() : sign * std::numeric_limits<double>::infinity();
  return sign * (exponent == 0 ? std::ldexp(fraction, -24) : std::ldexp(fraction + 1024, exponent - 25));
}

using RowPointers = std::array<const char*, 256>;

template <class T, bool swapped>
T load_as(const char* p) {
  if constexpr (!swapped || sizeof(T) == 1) {
    T value;
    std::memcpy(&value, p, sizeof(T));
    return value;
  } else if constexpr (sizeof(T) == 2) {
    return std::bit_cast<T>(__builtin_bswap16(load_as<std::uint16_t, false>(p)));
  } else if constexpr (sizeof(T) == 4) {
    return std::bit_cast<T>(__builtin_bswap32(load_as<std::uint32_t, false>(p)));
  } else {
    return std::bit_cast<T>(__builtin_bswap64(load_as<std::uint64_t, false>(p)));
  }
}

/// Appends a field of all rows. One append of a block costs less than one of each number, and leaves no memory to be cleared first.
template <class Number, class Load>
void append_block(std::vector<Number>& column, std::size_t count, const Load& load) {
  std::array<Number, RowPointers{}.size()> block;
  for (std::size_t i = 0; i < count; ++i) block[i] = static_cast<Number>(load(i));
  column.insert(column.end(), block.begin(), block.begin() + static_cast<std::ptrdiff_t>(count));
}

template <class T, class Number>
void append_field(std::vector<Number>& column, const RowPointers& rows, std::size_t count, const NumberField& field) {
  const std::size_t offset = field.offset;
  if (field.type.big_endian == (std::endian::native == std::endian::big))
    append_block(column, count, [&](std::size_t i) { return load_as<T, false>(rows[i] + offset); });
  else
    append_block(column, count, [&](std::size_t i) { return load_as<T, true>(rows[i] + offset); });
}

template <class Signed, class Unsigned>
void append_integers(RawColumn& column, const RowPointers& rows, std::size_t count, const NumberField& field) {
  field.type.kind == 'i' ? append_field<Signed>(column.integers, rows, count, field) : append_field<Unsigned>(column.integers, rows, count, field);
}

/// Eight unsigned bytes fit the integers of a column up to 2^63.
bool are_too_large(const RawColumn& column, const RowPointers& rows, std::size_t count, const NumberField& field) {
  return field.type.kind == 'u' &&
         (!column.numbers.empty() || std::any_of(rows.begin(), rows.begin() + static_cast<std::ptrdiff_t>(count), [&](const char* row) {
           return load<std::uint64_t>(row + field.offset, field.type.big_endian) > std::numeric_limits<std::int64_t>::max();
         }));
}

void append_column(RawColumn& column, const RowPointers& rows, std::size_t count, const NumberField& field) {
  const bool floating = field.type.kind == 'f';
  switch (field.type.bytes) {
    case 1:
      return append_integers<std::int8_t, std::uint8_t>(column, rows, count, field);
    case 2:
      if (!floating) return append_integers<std::int16_t, std::uint16_t>(column, rows, count, field);
      return append_block(column.numbers, count,
                          [&](std::size_t i) { return half_precision(load<std::uint16_t>(rows[i] + field.offset, field.type.big_endian)); });
    case 4:
      return floating ? append_field<float>(column.numbers, rows, count, field)
                      : append_integers<std::int32_t, std::uint32_t>(column, rows, count, field);
    default:
      if (floating) return append_field<double>(column.numbers, rows, count, field);
      if (!are_too_large(column, rows, count, field)) return append_integers<std::int64_t, std::uint64_t>(column, rows, count, field);
      column.make_numbers();
      append_field<std::uint64_t>(column.numbers, rows, count, field);
  }
}

}  // namespace

std::optional<NumberType> number_type(std::string_view name) {
  if (name.size() != 2) return std::nullopt;
  const NumberType type{name[0], static_cast<std::size_t>(name[1] - '0'), false};
  const bool integer = type.kind == 'i' || type.kind == 'u';
  const bool sized = type.bytes == 2 || type.bytes == 4 || type.bytes == 8 || (integer && type.bytes == 1);
  return (integer || type.kind == 'f') && sized ? std::optional(type) : std::nullopt;
}

ColumnBuilder::ColumnBuilder(std::vector<NumberField> fields, std::size_t rows) : fields_(std::move(fields)), columns_(fields_.size()) {
  for (std::size_t c = 0; c < fields_.size(); ++c) {
    if (fields_[c].type.kind == 'f')
      columns_[c].numbers.reserve(rows);
    else
      columns_[c].integers.reserve(rows);
  }
}

void ColumnBuilder::add(const char* first, std::size_t stride, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) add(first + stride * i);
}

void ColumnBuilder::flush() {
  for (std::size_t c = 0; c < fields_.size(); ++c) append_column(columns_[c], rows_, gathered_, fields_[c]);
  gathered_ = 0;
}

std::vector<RawColumn> ColumnBuilder::take() {
  flush();
  return std::move(columns_);
}

void MessageLosses::add_warnings(const std::string& file, std::vector<std::string>& warnings) const {
  if (skipped > 0) warnings.push_back(fmt::format("{}: {} bytes are no messages and were passed over: samples may be missing", file, skipped));
  if (unfinished > 0) warnings.push_back(fmt::format("{}: {} bytes at the end are an unfinished message, which is not read", file, unfinished));
}

void add_counted(ColumnBuilder& builder, const char* first, std::size_t stride, std::size_t count, const ReadingMeter& meter) {
  constexpr std::size_t at_once = 65536;
  for (std::size_t row = 0; row < count; row += at_once) {
    const std::size_t rows = std::min(at_once, count - row);
    builder.add(first + stride * row, stride, rows);
    meter.add(rows);
  }
}

}  // namespace imulab::recording_io
