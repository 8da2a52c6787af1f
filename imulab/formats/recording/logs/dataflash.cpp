// ArduPilot's DataFlash logs (.bin): a table for each message and sensor. The log defines its messages itself (FMT), and their units (FMTU, UNIT,
// MULT).
#include "imulab/formats/recording/format.hpp"
#include "imulab/formats/recording/logs/binary.hpp"
#include "imulab/formats/recording/logs/dataflash_definitions.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/reading_meter.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <string>
#include <utility>

namespace imulab::recording_io {
namespace {

constexpr std::string_view message_begin("\xA3\x95", 2);

bool is_dataflash(std::string_view head) { return head.starts_with("\xA3\x95\x80"); }

/// Calls `message(id, bytes)` for each message. `length(id)`: of its messages as defined so far; 0 where it is not.
template <class Length, class OnMessage>
MessageLosses walk_dataflash(std::string_view text, const Length& length, const OnMessage& message) {
  MessageLosses losses;
  const ReadingMeter meter(text.size());
  std::size_t at = 0;
  while (text.size() - at >= 3) {
    const auto id = static_cast<unsigned char>(text[at + 2]);
    const std::size_t size = text[at] == message_begin[0] && text[at + 1] == message_begin[1] ? length(id) : 0;
    if (size < 3) {
      const std::size_t next = std::min(text.find(message_begin, at + 1), text.size());
      losses.skipped += next - at;
      at = next;
      continue;
    }
    if (text.size() - at < size) break;
    message(id, text.substr(at, size));
    meter.add(size);
    at += size;
  }
  losses.unfinished = text.size() - at;
  return losses;
}

struct DataflashTable {
  TableDescription description;
  unsigned char id = 0;
  std::size_t instance = 0;
};

struct DataflashContents {
  DataflashDefinitions definitions;
  std::vector<DataflashTable> tables;  // those with rows
  MessageLosses losses;

  /// The instance of a message; 0 where it has none.
  std::size_t instance(unsigned char id, std::string_view bytes) const {
    const std::size_t offset = definitions.instance_offset(id);
    return offset < bytes.size() ? static_cast<unsigned char>(bytes[offset]) : 0;
  }
};

DataflashContents dataflash_contents(std::string_view text) {
  DataflashContents contents;
  std::vector<std::array<std::size_t, 256>> rows(256);
  const auto length = [&](unsigned char id) { return contents.definitions.length(id); };
  bool again = false;
  contents.losses = walk_dataflash(text, length, [&](unsigned char id, std::string_view bytes) {
    const std::size_t instance = contents.instance(id, bytes);
    ++rows[id][instance];
    if (!contents.definitions.defines_others(id)) return;
    const auto changed = contents.definitions.add(bytes);
    if (changed && std::any_of(rows[*changed].begin(), rows[*changed].end(), [](std::size_t n) { return n > 0; })) again = true;
  });
  if (again) {  // instances were defined after the first messages
    rows.assign(256, {});
    walk_dataflash(text, length, [&](unsigned char id, std::string_view bytes) { ++rows[id][contents.instance(id, bytes)]; });
  }
  for (std::size_t id = 0; id < 256; ++id) {
    const std::vector<DataflashColumn> columns = contents.definitions.columns(static_cast<unsigned char>(id));
    const std::string& name = contents.definitions[static_cast<unsigned char>(id)].name;
    for (std::size_t instance = 0; instance < 256; ++instance) {
      if (rows[id][instance] == 0 || columns.empty()) continue;
      TableDescription table{instance == 0 ? name : fmt::format("{}.{}", name, instance), name, {}, rows[id][instance]};
      for (const DataflashColumn& column : columns) table.columns.push_back(column.description);
      contents.tables.push_back({std::move(table), static_cast<unsigned char>(id), instance});
    }
  }
  return contents;
}

std::vector<TableDescription> descriptions_of(const DataflashContents& contents) {
  std::vector<TableDescription> descriptions;
  for (const DataflashTable& table : contents.tables) descriptions.push_back(table.description);
  return descriptions;
}

std::vector<TableDescription> describe_dataflash(const TableRequest& request) {
  const MappedFile file(request.file);
  return descriptions_of(dataflash_contents(file.text()));
}

void divide(RawColumn& column, double divisor) {
  if (divisor == 1) return;
  column.make_numbers();
  for (double& number : column.numbers) number /= divisor;
}

void read_dataflash(const TableRequest& request, const Wanted& wanted, const PieceSink& sink) {
  const MappedFile mapped(request.file);
  const std::string file = request.file.string();
  const DataflashContents contents = dataflash_contents(mapped.text());
  const std::vector<TableDescription> descriptions = descriptions_of(contents);
  const TableDescription& description = find_table(descriptions, request.topic, file);
  const DataflashTable& table = contents.tables[static_cast<std::size_t>(&description - descriptions.data())];
  const std::vector<DataflashColumn> all = contents.definitions.columns(table.id);
  std::vector<NumberField> fields;
  std::vector<double> divisors;
  for (const Column& column : wanted.columns) {
    const DataflashColumn& found = all[find_column(description, column, file)];
    fields.push_back(found.field);
    divisors.push_back(found.divisor);
  }
  ColumnBuilder builder(std::move(fields), description.rows);
  walk_dataflash(
      mapped.text(), [&](unsigned char id) { return contents.definitions.length(id); },
      [&](unsigned char id, std::string_view bytes) {
        if (id == table.id && contents.instance(id, bytes) == table.instance) builder.add(bytes.data());
      });
  TableRows rows{builder.take(), "message", {}};
  for (std::size_t c = 0; c < rows.columns.size(); ++c) divide(rows.columns[c], divisors[c]);
  contents.losses.add_warnings(file, rows.warnings);
  sink(std::move(rows));
}

}  // namespace

RecordingFormat dataflash_format() {
  return {.name = "ArduPilot DataFlash", .recognizes = is_dataflash, .describe = describe_dataflash, .read = read_dataflash};
}

}  // namespace imulab::recording_io
