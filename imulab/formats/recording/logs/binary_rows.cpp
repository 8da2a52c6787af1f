// Rows of binary numbers whose layout the session declares: "f8x7", ">i2x6 u4 +64".
#include "imulab/error.hpp"
#include "imulab/formats/recording/format.hpp"
#include "imulab/formats/recording/logs/binary.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/reading_meter.hpp"
#include "imulab/formats/text/take_until.hpp"

#include <fmt/core.h>

#include <charconv>
#include <optional>
#include <string>
#include <utility>

namespace imulab::recording_io {
namespace {

struct RowLayout {
  std::vector<NumberField> fields;
  std::size_t row = 0;   // bytes
  std::size_t head = 0;  // bytes before the first row
};

std::optional<std::size_t> size_in(std::string_view text) {
  std::size_t size = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), size);
  return error == std::errc() && end == text.data() + text.size() ? std::optional(size) : std::nullopt;
}

/// Adds a word of the layout; false where it is none.
bool add_word(RowLayout& layout, std::string_view word) {
  if (word.starts_with('+')) {
    const auto head = size_in(word.substr(1));
    layout.head = head.value_or(0);
    return head.has_value();
  }
  const bool big_endian = word.starts_with('>');
  if (big_endian || word.starts_with('<')) word.remove_prefix(1);
  const bool repeated = word.size() > 3 && word[2] == 'x';
  auto type = number_type(word.substr(0, 2));
  const auto count = repeated ? size_in(word.substr(3)) : word.size() == 2 ? std::optional<std::size_t>(1) : std::nullopt;
  if (!type || *type == NumberType{'f', 2, false} || !count || *count == 0 || *count > 4096) return false;
  type->big_endian = big_endian;
  for (std::size_t i = 0; i < *count; ++i, layout.row += type->bytes) layout.fields.push_back({*type, layout.row});
  return layout.fields.size() <= 4096;
}

RowLayout row_layout(const TableRequest& request) {
  RowLayout layout;
  for (std::string_view rest = request.layout; !rest.empty();) {
    const std::string_view word = text::take_until(rest, ' ');
    if (!word.empty() && !add_word(layout, word))
      throw Error(
          fmt::format("{}: layout \"{}\": {} is no type; expected words such as f8, f4x6, >i2x3 (types i1 u1 i2 u2 i4 u4 i8 u8 f4 f8) or +128, bytes "
                      "before the first row",
                      request.file.string(), request.layout, word));
  }
  if (layout.fields.empty())
    throw Error(fmt::format("{}: layout \"{}\" has no numbers; expected types such as f8x7", request.file.string(), request.layout));
  return layout;
}

/// The rows of a file, whose bytes are given.
TableDescription row_table(const RowLayout& layout, std::string_view text, const std::string& file) {
  if (text.size() < layout.head || text.size() - layout.head < layout.row)
    throw Error(fmt::format("{}: has {} bytes; expected {} before the first row and {} in each", file, text.size(), layout.head, layout.row));
  TableDescription table;
  for (std::size_t c = 1; c <= layout.fields.size(); ++c) table.columns.push_back({std::to_string(c)});
  table.rows = (text.size() - layout.head) / layout.row;
  return table;
}

std::vector<TableDescription> describe_rows(const TableRequest& request) {
  const MappedFile file(request.file);
  return {row_table(row_layout(request), file.text(), request.file.string())};
}

void read_binary_rows(const TableRequest& request, const Wanted& wanted, const PieceSink& sink) {
  const RowLayout layout = row_layout(request);
  const MappedFile mapped(request.file);
  const std::string file = request.file.string();
  const TableDescription table = row_table(layout, mapped.text(), file);
  if (!request.topic.empty())
    throw Error(fmt::format("{}: topic {} is not there; expected none, since rows of binary numbers are one table", file, request.topic));
  std::vector<NumberField> fields;
  for (const Column& column : wanted.columns) fields.push_back(layout.fields[find_column(table, column, file)]);
  ColumnBuilder builder(std::move(fields), table.rows);
  add_counted(builder, mapped.text().data() + layout.head, layout.row, table.rows, ReadingMeter(table.rows));
  TableRows rows;
  rows.columns = builder.take();
  if (const std::size_t left = (mapped.text().size() - layout.head) % layout.row; left != 0)
    rows.warnings.push_back(fmt::format("{}: {} bytes are left after {} rows of {} bytes: the file ends inside a row, or the layout is not \"{}\"",
                                        file, left, table.rows, layout.row, request.layout));
  sink(std::move(rows));
}

}  // namespace

RecordingFormat binary_rows_format() {
  return {.name = "rows of binary numbers (layout)",
          .recognizes = [](std::string_view) { return false; },
          .describe = describe_rows,
          .read = read_binary_rows,
          .of_layout = true};
}

}  // namespace imulab::recording_io
