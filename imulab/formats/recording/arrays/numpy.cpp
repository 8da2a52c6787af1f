// Arrays that NumPy saved: .npy, and .npz, a zip archive of them.
#include "imulab/error.hpp"
#include "imulab/formats/recording/archive/zip.hpp"
#include "imulab/formats/recording/arrays/arrays.hpp"
#include "imulab/formats/recording/arrays/npy_header.hpp"
#include "imulab/formats/recording/format.hpp"
#include "imulab/formats/recording/logs/binary.hpp"
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

  bool is_deflated(std::size_t index) const { return !members.empty() && members[index].deflated; }
  std::vector<NumberArray> numbers() const {
    std::vector<NumberArray> result;
    for (std::size_t i = 0; i < arrays.size(); ++i) {
      NumberArray& array = result.emplace_back(arrays[i].array);
      if (arrays[i].by_column && is_deflated(i))  // all are in memory, or read once for each piece
        for (ColumnDescription& column : array.columns) column.only_whole = true;
    }
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

/// Some columns of one array, some rows after the other.
class ArrayReader {
 public:
  ArrayReader(std::string_view text, const NumpyFile& file, std::size_t index, std::vector<std::size_t> wanted, const std::string& place)
      : array_(file.arrays[index]), wanted_(std::move(wanted)) {
    for (const std::size_t c : wanted_) fields_.push_back(array_.fields[c]);
    if (!file.is_deflated(index)) {
      next_ = (file.members.empty() ? text : file.members[index].stored).data() + array_.offset;
      return;
    }
    inflater_ = std::make_unique<ZipReader>(file.members[index], place + ": " + array_.array.name);
    std::string head(array_.offset, '\0');
    inflater_->read(head.data(), head.size());
  }
  /// Column stands after column in deflated bytes.
  bool only_whole() const { return inflater_ != nullptr && array_.by_column; }
  /// The number of rows, or numbers, that a meter counts.
  std::size_t steps() const { return array_.array.rows * (only_whole() ? array_.fields.size() : 1); }

  std::vector<RawColumn> next(std::size_t rows, const ReadingMeter& meter) {
    if (only_whole()) return inflate_columns(rows, meter);
    ColumnBuilder builder(fields_, rows);
    if (inflater_ != nullptr) {
      inflate(rows, &builder, meter);
    } else {
      add_counted(builder, next_, array_.stride, rows, meter);
      next_ += rows * array_.stride;
    }
    return builder.take();
  }
  void expect_intact() const {
    if (inflater_ != nullptr) inflater_->expect_intact();
  }

 private:
  /// Adds rows to a builder, or passes over them; only some of their bytes are in memory at once.
  void inflate(std::size_t rows, ColumnBuilder* builder, const ReadingMeter& meter) {
    const std::size_t at_once = std::max<std::size_t>(1, 65536 / array_.stride);
    buffer_.resize(at_once * array_.stride);
    for (std::size_t row = 0; row < rows; row += at_once) {
      const std::size_t count = std::min(at_once, rows - row);
      inflater_->read(buffer_.data(), count * array_.stride);
      if (builder != nullptr) {
        builder->add(buffer_.data(), array_.stride, count);
        builder->flush();
      }
      meter.add(count);
    }
  }
  std::vector<RawColumn> inflate_columns(std::size_t rows, const ReadingMeter& meter) {
    std::vector<RawColumn> columns(wanted_.size());
    for (std::size_t c = 0; c < array_.fields.size(); ++c) {
      const bool is_wanted = std::find(wanted_.begin(), wanted_.end(), c) != wanted_.end();
      ColumnBuilder builder({{array_.fields[c].type, 0}}, is_wanted ? rows : 0);
      inflate(rows, is_wanted ? &builder : nullptr, meter);
      const RawColumn column = std::move(builder.take().front());
      for (std::size_t k = 0; k < wanted_.size(); ++k)
        if (wanted_[k] == c) columns[k] = column;
    }
    return columns;
  }

  const NpyArray& array_;
  std::vector<std::size_t> wanted_;
  std::vector<NumberField> fields_;
  const char* next_ = nullptr;           // of an array that is not deflated
  std::unique_ptr<ZipReader> inflater_;  // of one that is
  std::string buffer_;
};

std::vector<TableDescription> describe_numpy(const TableRequest& request) {
  const MappedFile mapped(request.file);
  return descriptions_of(read_heads(mapped.text(), request.file.string()).numbers());
}

void read_numpy(const TableRequest& request, const Wanted& wanted, const PieceSink& sink) {
  constexpr std::size_t rows_of_piece = std::size_t{1} << 17;
  const MappedFile mapped(request.file);
  const std::string file = request.file.string();
  const NumpyFile heads = read_heads(mapped.text(), file);
  const std::vector<ArrayColumn> places = find_array_columns(heads.numbers(), request.topic, wanted.columns, file);
  if (places.empty()) return;
  std::vector<ArrayReader> arrays;
  std::vector<std::vector<std::size_t>> to_columns;
  std::size_t steps = 0;
  bool whole = !wanted.in_pieces;
  for_each_array(places, heads.arrays.size(), [&](std::size_t a, const std::vector<std::size_t>& own, const std::vector<std::size_t>& to) {
    arrays.emplace_back(mapped.text(), heads, a, own, file);
    to_columns.push_back(to);
    steps += arrays.back().steps();
    whole = whole || arrays.back().only_whole();
  });
  const std::size_t rows = heads.arrays[places.front().array].array.rows, at_once = whole ? rows : rows_of_piece;
  const ReadingMeter meter(steps);
  for (std::size_t row = 0; row < rows; row += at_once) {
    TableRows piece;
    piece.columns.resize(places.size());
    if (row == 0) piece.warnings = heads.warnings;
    for (std::size_t a = 0; a < arrays.size(); ++a) {
      std::vector<RawColumn> read = arrays[a].next(std::min(at_once, rows - row), meter);
      if (rows - row <= at_once) arrays[a].expect_intact();
      for (std::size_t k = 0; k < read.size(); ++k) piece.columns[to_columns[a][k]] = std::move(read[k]);
    }
    mapped.release(mapped.text().size());
    if (!sink(std::move(piece))) return;
  }
}

}  // namespace

RecordingFormat numpy_format() {
  return {.name = "NumPy .npy or .npz", .recognizes = is_numpy, .describe = describe_numpy, .read = read_numpy, .in_pieces = true};
}

}  // namespace imulab::recording_io
