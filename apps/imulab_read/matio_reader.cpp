// MATLAB's files of version 4 and 5 as libmatio reads them: variables, and fields of structures.
#include "imulab/error.hpp"
#include "imulab/formats/recording/arrays/arrays.hpp"
#include "imulab/formats/recording/child/child_tables.hpp"
#include "imulab/formats/recording/logs/binary.hpp"
#include "imulab/formats/text/file.hpp"

#include <fmt/core.h>

#include "apps/imulab_read/readers.hpp"
#include "apps/imulab_read/sandbox.hpp"
#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <libdeflate.h>
#include <limits>
#include <matio.h>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <vector>
#include <zlib.h>

namespace imulab::recording_io {
namespace {

struct FreeMemory {
  void operator()(void* memory) const { std::free(memory); }
};

/// Where the variable at `offset` ends, by its own head; 0 where no head is there.
std::uint64_t end_of_variable(std::string_view text, std::uint64_t offset, bool version_4) {
  if (!version_4) {
    constexpr std::uint32_t matrix = 14, compressed = 15;
    const bool big_endian = text.substr(126, 2) == "MI";
    if (text.size() - offset < 8) return 0;
    const auto type = load<std::uint32_t>(text.data() + offset, big_endian), bytes = load<std::uint32_t>(text.data() + offset + 4, big_endian);
    return type == matrix || type == compressed ? offset + 8 + bytes : 0;
  }
  constexpr std::uint64_t head = 20;
  if (text.size() - offset < head) return 0;
  const bool big_endian = load<std::uint32_t>(text.data() + offset, false) / 1000 > 5;  // its thousands say so: 0 or 1
  const auto number = [&](std::size_t i) { return std::uint64_t{load<std::uint32_t>(text.data() + offset + 4 * i, big_endian)}; };
  constexpr std::array<std::uint64_t, 6> bytes{8, 4, 4, 2, 2, 1};
  const std::uint64_t precision = number(0) / 10 % 10;
  if (precision > 5) return 0;
  if (number(1) > 0 && number(2) > text.size() / number(1)) return text.size() + 1;  // beyond the end, whatever a number's size
  return offset + head + number(4) + number(1) * number(2) * bytes[precision] * (number(3) == 1 ? 2 : 1);
}

/// The unpacked size of a compressed variable by its head; nothing where that is no variable.
std::optional<std::uint64_t> unpacked_size(std::string_view packed, bool big_endian) {
  std::array<char, 8> head{};
  z_stream stream{};
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
  stream.avail_in = static_cast<uInt>(packed.size());
  stream.next_out = reinterpret_cast<Bytef*>(head.data());
  stream.avail_out = static_cast<uInt>(head.size());
  if (inflateInit(&stream) != Z_OK) throw std::bad_alloc();
  inflate(&stream, Z_SYNC_FLUSH);
  const bool whole = stream.avail_out == 0;
  inflateEnd(&stream);
  constexpr std::uint32_t matrix = 14;
  if (!whole || load<std::uint32_t>(head.data(), big_endian) != matrix) return std::nullopt;
  return std::uint64_t{head.size()} + load<std::uint32_t>(head.data() + 4, big_endian);
}

/// Throws Error where a compressed variable is not what was written: libmatio does not look at its sum, and takes seconds on some that are damaged.
void expect_sound(std::string_view packed, bool big_endian, const std::string& place) {
  constexpr std::uint64_t most_packed = 1100;  // deflate's own limit is 1032
  const std::optional<std::uint64_t> size = unpacked_size(packed, big_endian);
  const bool possible = size && *size <= most_packed * packed.size();
  const std::unique_ptr<char, FreeMemory> buffer(possible ? static_cast<char*>(std::malloc(*size)) : nullptr);
  if (possible && !buffer) throw std::bad_alloc();
  const std::unique_ptr<libdeflate_decompressor, void (*)(libdeflate_decompressor*)> unpacker(libdeflate_alloc_decompressor(),
                                                                                              libdeflate_free_decompressor);
  if (!unpacker) throw std::bad_alloc();
  if (!possible || libdeflate_zlib_decompress(unpacker.get(), packed.data(), packed.size(), buffer.get(), *size, nullptr) != LIBDEFLATE_SUCCESS)
    throw Error(place + ": a compressed variable is damaged (its sum does not fit); expected a whole file");
}

/// Throws Error where the file ends inside a variable: libmatio makes up what is missing; or where a compressed one is damaged.
void expect_whole_mat(const std::filesystem::path& path) {
  const MappedFile mapped(path);
  const std::string_view text = mapped.text();
  const bool version_4 = !text.starts_with("MATLAB ");
  for (std::uint64_t offset = version_4 ? 0 : 128; offset < text.size();) {
    const std::uint64_t end = end_of_variable(text, offset, version_4);
    if (end > text.size() || (end == 0 && text.size() - offset < 20))
      throw Error(fmt::format("{}: ends inside a variable, at byte {}; expected a whole file", path.string(), text.size()));
    if (end <= offset) return;  // damaged otherwise, which libmatio says
    if (!version_4) {
      constexpr std::uint32_t compressed = 15;
      const bool big_endian = text.substr(126, 2) == "MI";
      if (load<std::uint32_t>(text.data() + offset, big_endian) == compressed)
        expect_sound(text.substr(offset + 8, end - offset - 8), big_endian, fmt::format("{}: byte {}", path.string(), offset));
    }
    offset = end;
  }
}

struct CloseMat {
  void operator()(mat_t* file) const { Mat_Close(file); }
  void operator()(matvar_t* variable) const { Mat_VarFree(variable); }
};

/// A variable, or a field of one, that is a table of numbers.
struct MatArray {
  NumberArray array;
  matvar_t* variable = nullptr;
  NumberType type;
  bool lying = false;  // 3 x N
};

struct MatFile {
  std::string name;
  std::uintmax_t bytes = 0;
  std::unique_ptr<mat_t, CloseMat> file;
  std::vector<std::unique_ptr<matvar_t, CloseMat>> variables;
  std::vector<MatArray> arrays;

  std::vector<NumberArray> numbers() const {
    std::vector<NumberArray> result;
    for (const MatArray& a : arrays) result.push_back(a.array);
    return result;
  }
};

std::optional<NumberType> mat_type(const matvar_t& variable) {
  const bool big_endian = std::endian::native == std::endian::big;  // in memory
  switch (variable.class_type) {
    case MAT_C_DOUBLE:
      return NumberType{'f', 8, big_endian};
    case MAT_C_SINGLE:
      return NumberType{'f', 4, big_endian};
    case MAT_C_INT8:
      return NumberType{'i', 1, big_endian};
    case MAT_C_UINT8:
      return NumberType{'u', 1, big_endian};
    case MAT_C_INT16:
      return NumberType{'i', 2, big_endian};
    case MAT_C_UINT16:
      return NumberType{'u', 2, big_endian};
    case MAT_C_INT32:
      return NumberType{'i', 4, big_endian};
    case MAT_C_UINT32:
      return NumberType{'u', 4, big_endian};
    case MAT_C_INT64:
      return NumberType{'i', 8, big_endian};
    case MAT_C_UINT64:
      return NumberType{'u', 8, big_endian};
    default:
      return std::nullopt;
  }
}

void add_variable(MatFile& file, matvar_t* variable, const std::string& name, int depth) {
  if (variable == nullptr || variable->rank != 2 || variable->dims == nullptr) return;
  const std::size_t rows = variable->dims[0], columns = variable->dims[1];
  if (variable->class_type == MAT_C_STRUCT && rows == 1 && columns == 1 && depth < 8) {
    const unsigned fields = Mat_VarGetNumberOfFields(variable);
    char* const* const names = Mat_VarGetStructFieldnames(variable);
    for (unsigned i = 0; i < fields && names != nullptr; ++i)
      if (names[i] != nullptr) add_variable(file, Mat_VarGetStructFieldByIndex(variable, i, 0), name + "." + names[i], depth + 1);
    return;
  }
  const auto type = mat_type(*variable);
  if (!type || variable->isComplex != 0 || rows == 0 || columns == 0) return;
  // A compressed file holds no more than this; the sizes may be damaged.
  if (static_cast<double>(rows) * static_cast<double>(columns) > 1100.0 * static_cast<double>(file.bytes) ||
      std::max(rows, columns) > static_cast<std::size_t>(std::numeric_limits<int>::max()))
    throw Error(fmt::format("{}: {}: is larger than the file can hold", file.name, name));
  const ArrayShape shape = table_shape({rows, columns}, false);
  file.arrays.push_back({{name, shape.rows, column_names(name, shape.columns)}, variable, *type, !shape.by_column});
}

MatFile open_mat(const std::filesystem::path& path) {
  MatFile file;
  file.name = path.string();
  file.bytes = std::filesystem::file_size(path);
  expect_whole_mat(path);
  file.file.reset(Mat_Open(path.c_str(), MAT_ACC_RDONLY));
  if (!file.file) throw Error(file.name + ": cannot be opened as a MATLAB file; expected a whole one (is it truncated?)");
  return file;
}

void find_variables(MatFile& file) {
  while (matvar_t* const variable = Mat_VarReadNextInfo(file.file.get())) {
    file.variables.emplace_back(variable);
    if (variable->name != nullptr) add_variable(file, variable, variable->name, 0);
  }
}

/// Reads `count` numbers, which follow `first` of them in the file: column by column.
void read_numbers(const MatFile& file, const MatArray& array, void* to, std::size_t first, std::size_t count) {
  if (Mat_VarReadDataLinear(file.file.get(), array.variable, to, static_cast<int>(first), 1, static_cast<int>(count)) != 0)
    throw Error(fmt::format("{}: {}: cannot be read; expected a whole variable", file.name, array.array.name));
}

constexpr std::size_t rows_at_once = 1 << 14;

/// Sends some columns of an array whose bytes are in the file as they are: in parts that stay in the processor's cache.
void send_plain(const MatFile& file, const MatArray& array, const std::vector<std::size_t>& wanted, const SendRows& send) {
  const std::size_t size = array.type.bytes, rows = array.array.rows, columns = array.array.columns.size();
  std::vector<char> part(std::min(rows, rows_at_once) * size * (array.lying ? columns : wanted.size()));
  std::vector<NumberField> fields;
  for (std::size_t k = 0; k < wanted.size(); ++k) fields.push_back({array.type, size * (array.lying ? wanted[k] : k * std::min(rows, rows_at_once))});
  for (std::size_t row = 0; row < rows; row += rows_at_once) {
    const std::size_t count = std::min(rows_at_once, rows - row);
    if (array.lying) read_numbers(file, array, part.data(), row * columns, count * columns);
    for (std::size_t k = 0; k < wanted.size() && !array.lying; ++k)
      read_numbers(file, array, part.data() + fields[k].offset, wanted[k] * rows + row, count);
    send_rows(fields, part.data(), size * (array.lying ? columns : 1), count, send);
  }
}

/// Sends some columns of an array that is read as a whole: compressed, libmatio begins anew for each part.
void send_compressed(const MatFile& file, const MatArray& array, const std::vector<std::size_t>& wanted, const SendRows& send) {
  const std::size_t size = array.type.bytes, rows = array.array.rows, columns = array.array.columns.size();
  const std::unique_ptr<char, FreeMemory> buffer(static_cast<char*>(std::calloc(rows * columns, size)));  // zeros at no cost
  if (!buffer) throw std::bad_alloc();
  std::array<int, 2> start{0, 0}, stride{1, 1};
  std::array<int, 2> edge{static_cast<int>(array.variable->dims[0]), static_cast<int>(array.variable->dims[1])};
  if (Mat_VarReadData(file.file.get(), array.variable, buffer.get(), start.data(), stride.data(), edge.data()) != 0)
    throw Error(fmt::format("{}: {}: cannot be read; expected a whole variable", file.name, array.array.name));
  std::vector<NumberField> fields;
  for (const std::size_t c : wanted) fields.push_back({array.type, size * c * (array.lying ? 1 : rows)});
  const std::size_t stride_bytes = size * (array.lying ? columns : 1);
  for (std::size_t row = 0; row < rows; row += rows_at_once)
    send_rows(fields, buffer.get() + row * stride_bytes, stride_bytes, std::min(rows_at_once, rows - row), send);
}

void send_variable(const MatFile& file, const MatArray& array, const std::vector<std::size_t>& wanted, const SendRows& send) {
  const bool small = array.array.rows * array.array.columns.size() <= static_cast<std::size_t>(std::numeric_limits<int>::max());
  if (array.variable->compression == MAT_COMPRESSION_NONE && small) return send_plain(file, array, wanted, send);
  send_compressed(file, array, wanted, send);
}

}  // namespace

void answer_matlab(const ReadRequest& request, ToParent& to) {
  MatFile file = open_mat(request.task.file);
  close_sandbox(request.task.file);
  find_variables(file);
  if (request.describes) return send_tables(to, descriptions_of(file.numbers()));
  const SendColumn send = column_sender(to);
  const std::vector<ArrayColumn> places = find_array_columns(file.numbers(), request.topic, request.columns, file.name);
  for_each_array(places, file.arrays.size(), [&](std::size_t a, const std::vector<std::size_t>& chosen, const std::vector<std::size_t>& own) {
    send_variable(file, file.arrays[a], chosen, {send, own, file.arrays[a].array.rows});
  });
}

}  // namespace imulab::recording_io
