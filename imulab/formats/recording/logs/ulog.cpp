// PX4's ULog, as https://docs.px4.io/main/en/dev_log/ulog_file_format.html specifies it: a table for each message and instance.
#include "imulab/error.hpp"
#include "imulab/formats/recording/format.hpp"
#include "imulab/formats/recording/logs/binary.hpp"
#include "imulab/formats/recording/logs/ulog_definitions.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/reading_meter.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <utility>

namespace imulab::recording_io {
namespace {

constexpr std::string_view ulog_magic("ULog\x01\x12\x35", 7);
constexpr std::size_t ulog_head = 16, message_head = 3;
constexpr std::string_view sync_bytes("\x2F\x73\x13\x20\x25\x0C\xBB\x12", 8);

/// The types of messages, by their letters.
constexpr auto is_known = [] {
  std::array<bool, 256> known{};
  for (const char type : std::string_view("BFIMPQARDLCSO")) known[static_cast<unsigned char>(type)] = true;
  return known;
}();

bool is_ulog(std::string_view head) { return head.starts_with(ulog_magic); }

/// The losses of a log.
struct UlogLosses : MessageLosses {
  std::size_t dropouts = 0, dropout_ms = 0;
};

/// Walks over the messages of a log, one part after the other: data may have been appended after the end, to which the last message before need not
/// come.
class UlogReader {
 public:
  UlogReader(std::string_view text, std::string file) : text_(text), file_(std::move(file)) {
    if (text.size() < ulog_head) throw Error(file_ + ": ends inside its head; expected a log");
  }

  /// Calls `message(type, payload)` for each.
  template <class OnMessage>
  void walk(const OnMessage& message) {
    std::size_t at = ulog_head;
    std::vector<std::size_t> ends = part_ends();
    for (const std::size_t end : ends) {
      walk_part(at, end, message);
      at = end;
    }
  }
  const UlogLosses& losses() const { return losses_; }

 private:
  /// The ends of the parts, ascending; the last is the file's.
  std::vector<std::size_t> part_ends() const {
    std::vector<std::size_t> ends;
    const std::string_view flags = text_.substr(ulog_head);
    if (flags.size() >= message_head + 40 && flags[2] == 'B' && load<std::uint16_t>(flags.data()) >= 40) {
      const char* incompatible = flags.data() + message_head + 8;
      if ((incompatible[0] & ~1) != 0 || std::any_of(incompatible + 1, incompatible + 8, [](char c) { return c != 0; }))
        throw Error(file_ + ": is a log with features of a newer format; expected ULog as of version 1");
      for (std::size_t i = 0; i < 3 && incompatible[0] != 0; ++i) {
        const auto offset = load<std::uint64_t>(incompatible + 8 + 8 * i);
        if (offset > (ends.empty() ? ulog_head : ends.back()) && offset < text_.size()) ends.push_back(offset);
      }
    }
    ends.push_back(text_.size());
    return ends;
  }

  /// True if a message of a known type may begin here.
  bool begins_message(std::size_t at, std::size_t end) const {
    return end - at >= message_head && load<std::uint16_t>(text_.data() + at) > 0 && is_known[static_cast<unsigned char>(text_[at + 2])];
  }

  /// Where reading goes on after what is no message of a known type: behind one of a newer type, or at the next sync message.
  std::size_t next_message(std::size_t at, std::size_t end) {
    const std::size_t behind = at + message_head + load<std::uint16_t>(text_.data() + at);
    if (behind > at + message_head && behind <= end && (behind == end || begins_message(behind, end))) return behind;
    const std::size_t sync = text_.substr(0, end).find(sync_bytes, at);
    const std::size_t next = sync == std::string_view::npos ? end : sync + sync_bytes.size();
    losses_.skipped += next - at;
    return next;
  }

  template <class OnMessage>
  void walk_part(std::size_t at, std::size_t end, const OnMessage& message) {
    while (end - at >= message_head) {
      if (!begins_message(at, end)) {
        at = next_message(at, end);
        continue;
      }
      const std::size_t size = load<std::uint16_t>(text_.data() + at);
      const char type = text_[at + 2];
      if (end - at - message_head < size) break;
      const std::string_view payload = text_.substr(at + message_head, size);
      if (type == 'O' && size >= 2) {
        ++losses_.dropouts;
        losses_.dropout_ms += load<std::uint16_t>(payload.data());
      }
      message(type, payload);
      at += message_head + size;
      meter_.add(message_head + size);
    }
    losses_.unfinished += end - at;
  }

  std::string_view text_;
  std::string file_;
  UlogLosses losses_;
  ReadingMeter meter_{text_.size()};
};

std::vector<std::string> loss_warnings(const UlogLosses& losses, const std::string& file) {
  std::vector<std::string> warnings;
  if (losses.dropouts > 0)
    warnings.push_back(fmt::format("{}: {} dropout{} of the logger, {} ms together: messages of those times are missing", file, losses.dropouts,
                                   losses.dropouts == 1 ? "" : "s", losses.dropout_ms));
  losses.add_warnings(file, warnings);
  return warnings;
}

/// A message with its instance, which is a table.
struct UlogTable {
  std::string name, message;
  std::size_t rows = 0;
};

/// Which table a data message belongs to, as the log says while it is read.
class UlogTables {
 public:
  /// Takes the table of a subscription.
  void subscribe(std::string_view payload) {
    if (payload.size() < 4) return;
    const int instance = static_cast<unsigned char>(payload[0]);
    const std::string message(payload.substr(3));
    const std::string name = instance == 0 ? message : fmt::format("{}.{}", message, instance);
    if (!find(name)) tables_.push_back({name, message});
    const auto id = load<std::uint16_t>(payload.data() + 1);
    if (of_id_.size() <= id) of_id_.resize(id + std::size_t{1}, none);
    of_id_[id] = *find(name);
  }
  /// Index of the table of a data message.
  std::optional<std::size_t> table_of(std::string_view payload) const {
    if (payload.size() < 2) return std::nullopt;
    const auto id = load<std::uint16_t>(payload.data());
    return id < of_id_.size() && of_id_[id] != none ? std::optional(of_id_[id]) : std::nullopt;
  }
  std::optional<std::size_t> find(const std::string& name) const {
    for (std::size_t i = 0; i < tables_.size(); ++i)
      if (tables_[i].name == name) return i;
    return std::nullopt;
  }
  std::vector<UlogTable>& tables() { return tables_; }

 private:
  static constexpr auto none = static_cast<std::size_t>(-1);
  std::vector<UlogTable> tables_;
  std::vector<std::size_t> of_id_;
};

/// The definitions and tables of a log, and how many rows each has.
struct UlogContents {
  UlogDefinitions definitions;
  std::vector<TableDescription> tables;  // those with rows
  UlogLosses losses;
};

UlogContents ulog_contents(std::string_view text, const std::string& file) {
  UlogContents contents;
  UlogTables tables;
  UlogReader reader(text, file);
  reader.walk([&](char type, std::string_view payload) {
    if (type == 'F') contents.definitions.add(payload);
    if (type == 'A') tables.subscribe(payload);
    if (type == 'D')
      if (const auto table = tables.table_of(payload)) ++tables.tables()[*table].rows;
  });
  contents.losses = reader.losses();
  for (const UlogTable& table : tables.tables()) {
    if (table.rows == 0) continue;
    TableDescription& description = contents.tables.emplace_back(TableDescription{table.name, table.message, {}, table.rows});
    for (const UlogColumn& column : contents.definitions.columns(table.message, file)) description.columns.push_back(column.description);
  }
  return contents;
}

std::vector<TableDescription> describe_ulog(const TableRequest& request) {
  const MappedFile file(request.file);
  return ulog_contents(file.text(), request.file.string()).tables;
}

void read_ulog(const TableRequest& request, const Wanted& wanted, const PieceSink& sink) {
  const MappedFile mapped(request.file);
  const std::string file = request.file.string();
  const UlogContents contents = ulog_contents(mapped.text(), file);
  const TableDescription& table = find_table(contents.tables, request.topic, file);
  const std::vector<UlogColumn> all = contents.definitions.columns(table.type, file);
  std::vector<NumberField> fields;
  std::size_t needed = 0;
  for (const Column& column : wanted.columns) {
    fields.push_back(all[find_column(table, column, file)].field);
    needed = std::max(needed, fields.back().offset + fields.back().type.bytes);
  }
  ColumnBuilder builder(std::move(fields), table.rows);
  UlogTables tables;
  UlogReader reader(mapped.text(), file);
  std::size_t short_rows = 0;
  std::optional<std::size_t> own;
  reader.walk([&](char type, std::string_view payload) {
    if (type == 'A') {
      tables.subscribe(payload);
      own = tables.find(table.name);
    }
    if (type != 'D' || !own || tables.table_of(payload) != own) return;
    if (payload.size() - 2 < needed)
      ++short_rows;
    else
      builder.add(payload.data() + 2);
  });
  TableRows rows{builder.take(), "message", loss_warnings(contents.losses, file)};
  if (short_rows > 0)
    rows.warnings.push_back(fmt::format("{}: {}: {} messages are shorter than their definition: they are not read", file, table.name, short_rows));
  sink(std::move(rows));
}

}  // namespace

RecordingFormat ulog_format() { return {.name = "PX4 ULog", .recognizes = is_ulog, .describe = describe_ulog, .read = read_ulog}; }

}  // namespace imulab::recording_io
