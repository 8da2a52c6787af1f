// Arrays that NumPy saved: .npy, and .npz, a zip archive of them.
#include "imulab/core/error.hpp"
#include "imulab/formats/recording/arrays.hpp"
#include "imulab/formats/recording/binary.hpp"
#include "imulab/formats/recording/formats.hpp"
#include "imulab/formats/recording/npy_header.hpp"
#include "imulab/formats/recording/zip.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/reading_meter.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <memory>
#include <string>
#include <utility>

namespace imulab::recording_io {
namespace {

bool is_npz(std::string_view head) { return head.starts_with("PK\3\4"); }
bool is_numpy(std::string_view head) { return head.starts_with("\x93NUMPY") || is_npz(head); }

/// The arrays of a file, which has to stay.
struct NumpyFile {
  std::vector<NpyArray> arrays;
  std::vector<ZipMember> members;  // of the arrays; empty for .npy
  std::vector<std::string> warnings;

  std::vector<NumberArray> numbers() const {
    std::vector<NumberArray> result;
    for (const NpyArray& a : arrays) result.push_back(a.array);
    return result;
  }
};

NumpyFile read_npy_head(std::string_view text, const std::string& file) {
  const std::size_t head = npy_head_size(text);
  if (head == 0 || head > text.size()) throw Error(file + ": its head is damaged; expected an array as NumPy writes it");
  NpyArray array = npy_array(text.substr(0, head), text.size() - head, "", file);
  if (array.array.columns.empty())
    throw Error(fmt::format("{}: an array of {}, empty or of more than two dimensions; expected numbers in rows and columns", file, array.type));
  NumpyFile result;
  if (const std::size_t there = text.size() - head; there < array.bytes) {
    const std::size_t rows = there / array.stride;
    if (array.by_column || rows == 0)
      throw Error(fmt::format("{}: ends after {} of {} bytes of its numbers; expected all", file, there, array.bytes));
    result.warnings.push_back(fmt::format("{}: ends after {} of {} rows: the others are lost", file, rows, array.array.rows));
    array.array.rows = rows;
  }
  result.arrays.push_back(std::move(array));
  return result;
}

NumpyFile read_npz_heads(std::string_view text, const std::string& file) {
  NumpyFile result;
  for (ZipMember& member : zip_members(text, file)) {
    if (!member.name.ends_with(".npy")) continue;
    const std::string name = member.name.substr(0, member.name.size() - 4), place = file + ": " + name;
    std::string head(12, '\0');
    if (member.bytes < head.size()) throw Error(place + ": ends too early; expected an array as NumPy writes it");
    ZipReader reader(member, place);
    reader.read(head.data(), head.size());
    const std::size_t size = npy_head_size(head);
    if (size < head.size() || size > std::min(member.bytes, npy_longest_head))
      throw Error(place + ": its head is damaged; expected an array as NumPy writes it");
    head.resize(size);
    reader.read(head.data() + 12, size - 12);
    NpyArray array = npy_array(head, member.bytes - size, name, place);
    if (array.array.columns.empty()) continue;
    if (member.bytes - size < array.bytes)
      throw Error(fmt::format("{}: has {} of {} bytes of its numbers; expected all", place, member.bytes - size, array.bytes));
    result.arrays.push_back(std::move(array));
    result.members.push_back(std::move(member));
  }
  return result;
}

NumpyFile read_heads(std::string_view text, const std::string& file) { return is_npz(text) ? read_npz_heads(text, file) : read_npy_head(text, file); }

/// Deflated rows: only some of them are in memory at once.
std::vector<RawColumn> inflate_rows(ZipReader& reader, const NpyArray& array, std::vector<NumberField> fields) {
  ColumnBuilder builder(std::move(fields));
  const std::size_t at_once = std::max<std::size_t>(1, 65536 / array.stride);
  std::string buffer(at_once * array.stride, '\0');
  const ReadingMeter meter(array.array.rows);
  for (std::size_t row = 0; row < array.array.rows;) {
    const std::size_t rows = std::min(at_once, array.array.rows - row);
    reader.read(buffer.data(), rows * array.stride);
    builder.add(buffer.data(), array.stride, rows);
    builder.flush();
    meter.add(rows);
    row += rows;
  }
  reader.expect_intact();
  return builder.take();
}

/// The same where column stands after column.
std::vector<RawColumn> inflate_columns(ZipReader& reader, const NpyArray& array, const std::vector<std::size_t>& wanted) {
  std::vector<RawColumn> columns(wanted.size());
  const ReadingMeter meter(array.fields.size() * array.array.rows);
  for (std::size_t c = 0; c < array.fields.size(); ++c) {
    NpyArray one = array;
    one.fields = {{array.fields[c].type, 0}};
    const std::size_t at_once = 65536 / array.stride;
    std::string buffer(at_once * array.stride, '\0');
    ColumnBuilder builder(one.fields);
    const bool is_wanted = std::find(wanted.begin(), wanted.end(), c) != wanted.end();
    for (std::size_t row = 0; row < array.array.rows;) {
      const std::size_t rows = std::min(at_once, array.array.rows - row);
      reader.read(buffer.data(), rows * array.stride);
      if (is_wanted) builder.add(buffer.data(), array.stride, rows);
      builder.flush();
      meter.add(rows);
      row += rows;
    }
    RawColumn column = std::move(builder.take().front());
    for (std::size_t k = 0; k < wanted.size(); ++k)
      if (wanted[k] == c) columns[k] = column;
  }
  reader.expect_intact();
  return columns;
}

/// Some columns of one array.
std::vector<RawColumn> array_columns(std::string_view text, const NumpyFile& file, std::size_t index, const std::vector<std::size_t>& wanted,
                                     const std::string& place) {
  const NpyArray& array = file.arrays[index];
  std::vector<NumberField> fields;
  for (const std::size_t c : wanted) fields.push_back(array.fields[c]);
  if (!file.members.empty() && file.members[index].deflated) {
    ZipReader reader(file.members[index], place + ": " + array.array.name);
    std::string head(array.offset, '\0');
    reader.read(head.data(), head.size());
    return array.by_column ? inflate_columns(reader, array, wanted) : inflate_rows(reader, array, std::move(fields));
  }
  const std::string_view whole = file.members.empty() ? text : file.members[index].stored;
  ColumnBuilder builder(std::move(fields), array.array.rows);
  add_counted(builder, whole.data() + array.offset, array.stride, array.array.rows, ReadingMeter(array.array.rows));
  return builder.take();
}

std::vector<TableDescription> describe_numpy(const TableRequest& request) {
  const MappedFile mapped(request.file);
  return descriptions_of(read_heads(mapped.text(), request.file.string()).numbers());
}

RawTable numpy_columns(const TableRequest& request, const std::vector<Column>& columns) {
  const MappedFile mapped(request.file);
  const std::string file = request.file.string();
  NumpyFile heads = read_heads(mapped.text(), file);
  const std::vector<ArrayColumn> places = find_array_columns(heads.numbers(), request.topic, columns, file);
  RawTable raw = gather_columns(places, heads.arrays.size(), [&](std::size_t a, const std::vector<std::size_t>& wanted) {
    return array_columns(mapped.text(), heads, a, wanted, file);
  });
  raw.warnings = std::move(heads.warnings);
  return raw;
}

/// Some columns of one array, some rows after the other.
class NextRows {
 public:
  NextRows(std::string_view text, const NumpyFile& file, std::size_t index, const std::vector<std::size_t>& wanted, const std::string& place)
      : array_(file.arrays[index]) {
    for (const std::size_t c : wanted) fields_.push_back(array_.fields[c]);
    if (file.members.empty() || !file.members[index].deflated) {
      next_ = (file.members.empty() ? text : file.members[index].stored).data() + array_.offset;
      return;
    }
    reader_ = std::make_unique<ZipReader>(file.members[index], place + ": " + array_.array.name);
    std::string head(array_.offset, '\0');
    reader_->read(head.data(), head.size());
  }
  std::vector<RawColumn> next(std::size_t rows) {
    ColumnBuilder builder(fields_, rows);
    if (reader_ != nullptr) {
      inflated_.resize(rows * array_.stride);
      reader_->read(inflated_.data(), inflated_.size());
      builder.add(inflated_.data(), array_.stride, rows);
      return builder.take();
    }
    builder.add(next_, array_.stride, rows);
    next_ += rows * array_.stride;
    return builder.take();
  }
  void expect_intact() const {
    if (reader_ != nullptr) reader_->expect_intact();
  }

 private:
  const NpyArray& array_;
  std::vector<NumberField> fields_;
  const char* next_ = nullptr;
  std::unique_ptr<ZipReader> reader_;  // where it is deflated
  std::string inflated_;
};

/// Deflated columns that stand one after the other are all in memory, or read once for each piece.
std::size_t numpy_rows(const TableRequest& request, const std::vector<Column>& columns) {
  const MappedFile mapped(request.file);
  const NumpyFile heads = read_heads(mapped.text(), request.file.string());
  std::size_t rows = 0;
  for (const ArrayColumn& place : find_array_columns(heads.numbers(), request.topic, columns, request.file.string())) {
    const NpyArray& array = heads.arrays[place.array];
    if (array.by_column && !heads.members.empty() && heads.members[place.array].deflated) return 0;
    rows = array.array.rows;
  }
  return rows;
}

void numpy_pieces(const TableRequest& request, const std::vector<Column>& columns, const std::function<bool(RawTable&&)>& each) {
  constexpr std::size_t at_once = std::size_t{1} << 17;
  const MappedFile mapped(request.file);
  const std::string file = request.file.string();
  const NumpyFile heads = read_heads(mapped.text(), file);
  const std::vector<ArrayColumn> places = find_array_columns(heads.numbers(), request.topic, columns, file);
  if (places.empty()) return;
  std::vector<NextRows> arrays;
  std::vector<std::vector<std::size_t>> to_columns;
  for_each_array(places, heads.arrays.size(), [&](std::size_t a, const std::vector<std::size_t>& wanted, const std::vector<std::size_t>& to) {
    arrays.emplace_back(mapped.text(), heads, a, wanted, file);
    to_columns.push_back(to);
  });
  const std::size_t rows = heads.arrays[places.front().array].array.rows;
  const ReadingMeter meter(rows);
  for (std::size_t row = 0; row < rows; row += at_once) {
    RawTable piece;
    piece.columns.resize(places.size());
    if (row == 0) piece.warnings = heads.warnings;
    for (std::size_t a = 0; a < arrays.size(); ++a) {
      std::vector<RawColumn> read = arrays[a].next(std::min(at_once, rows - row));
      for (std::size_t k = 0; k < read.size(); ++k) piece.columns[to_columns[a][k]] = std::move(read[k]);
    }
    mapped.release(mapped.text().size());
    meter.add(std::min(at_once, rows - row));
    if (!each(std::move(piece))) return;
  }
  for (const NextRows& array : arrays) array.expect_intact();
}

}  // namespace

RecordingFormat numpy_format() {
  return {.name = "NumPy .npy or .npz",
          .recognizes = is_numpy,
          .describe = describe_numpy,
          .columns = numpy_columns,
          .rows = numpy_rows,
          .pieces = numpy_pieces};
}

}  // namespace imulab::recording_io
