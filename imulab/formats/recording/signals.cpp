#include "imulab/formats/recording/signals.hpp"

#include "imulab/error.hpp"
#include "imulab/formats/recording/archive/text_tables.hpp"
#include "imulab/formats/recording/arrays/arrays.hpp"
#include "imulab/formats/recording/imu_tables.hpp"
#include "imulab/formats/recording/table_reader.hpp"
#include "imulab/formats/recording/text/text_signals.hpp"
#include "imulab/formats/text/file.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

namespace imulab {
namespace {

using namespace recording_io;

/// "PX4 ULog: sensor_combined"
std::string format_text(const RecordingFormat& format, const TableDescription& table) {
  const std::string name = table.name == table.type || table.name.starts_with(table.type + ".") ? "" : table.type;
  std::string text(format.name);
  for (const std::string& part : {name, table.name})
    if (!part.empty()) text += (text.size() == format.name.size() ? ": " : " ") + part;
  return text;
}

/// All rows, or the first ones.
TableRows columns_of_head(const RecordingFormat& format, const TableRequest& request, const std::vector<TableDescription>& tables,
                          const std::vector<Column>& columns, std::size_t most_numbers) {
  const std::size_t rows = rows_of(tables, request.topic), most_rows = most_numbers / std::max<std::size_t>(1, columns.size());
  if (rows <= most_rows || !in_pieces(format, request, tables, columns)) {
    expect_memory_for(request.file.string(), rows, columns.size(), with_inspection);
    return read_columns(request, columns, format);
  }
  TableRows head;
  head.columns.resize(columns.size());
  format.read(request, {.columns = columns, .in_pieces = true}, [&](TableRows&& piece) {
    head.warnings.insert(head.warnings.end(), piece.warnings.begin(), piece.warnings.end());
    for (std::size_t c = 0; c < columns.size(); ++c) head.columns[c].append(std::move(piece.columns[c]));
    return head.size() < most_rows / part_of_long;
  });
  head.warnings.push_back(head_note(head.size()));
  return head;
}

/// The sampling rate that the file states beside its arrays.
void add_rate(const RecordingFormat& format, const TableRequest& request, const TableDescription& table, SignalTable& result) {
  const auto name = std::find_if(table.other_names.begin(), table.other_names.end(), names_rate);
  if (name == table.other_names.end()) return;
  format.read({request.file, *name, request.layout}, {.columns = {1}}, [&](TableRows&& value) {
    RawColumn& column = value.columns.front();
    column.make_numbers();
    if (column.size() == 1) result.rate_hz = column.numbers.front();
    return true;
  });
  if (result.rate_hz && !(*result.rate_hz >= 1e-3 && *result.rate_hz <= 1e6)) result.rate_hz.reset();  // as rate_hz may be declared
  result.rate_name = *name;
}

SignalTable signals_of(const RecordingFormat& format, const TableRequest& request, const std::vector<TableDescription>& tables,
                       std::size_t most_numbers) {
  const std::string file = request.file.string();
  const TableDescription& table = find_table(tables, request.topic, file);
  SignalTable result;
  result.file = file;
  result.topic = format.bag != nullptr || tables.size() > 1 ? table.name : "";
  result.format = format_text(format, table);
  std::vector<Column> columns;
  for (std::size_t i = 0; i < table.columns.size(); ++i) columns.push_back(column_named(table.columns[i].name, i));
  TableRequest own = request;
  own.topic = table.name;
  TableRows raw = columns_of_head(format, own, tables, columns, most_numbers);
  result.notes = raw.warnings;
  add_rate(format, own, table, result);
  for (std::size_t i = 0; i < columns.size(); ++i) {
    raw.columns[i].make_numbers();
    result.signals.push_back(
        {name_in_table(table.name, table.columns[i].name), table.columns[i].unit, columns[i], std::move(raw.columns[i].numbers)});
  }
  return result;
}

/// One of the texts of a folder or an archive.
SignalTable signals_of_text_table(const RecordingFormat& format, const TableRequest& request, bool only, std::size_t most_numbers) {
  const TextTable text = format.open_text(request);
  SignalTable table = std::move(tables_of_text_file(text.path(), "", request.layout, most_numbers).front());
  table.file = request.file.string();
  table.topic = only ? "" : request.topic;
  table.format = fmt::format("{}: {}, {}", format.name, request.topic, table.format);
  for (Signal& signal : table.signals) signal.name = name_in_table(request.topic, signal.name);
  return table;
}

}  // namespace

std::vector<SignalTable> read_tables(const std::filesystem::path& file, const std::vector<std::string>& topics,
                                     const std::vector<RecordingFormat>& formats, double longest_s, std::size_t most_numbers,
                                     const std::string& layout) {
  if (is_stream(file)) return tables_of_stream(file, topics.empty() ? "" : topics.front(), layout, longest_s);
  std::vector<SignalTable> out;
  TableRequest request{file, "", layout};
  const RecordingFormat& format = format_of(request, formats);
  if (format.is_text && format.open_text == nullptr) {
    for (const std::string& topic : topics.empty() ? std::vector<std::string>{""} : topics)
      for (SignalTable& table : tables_of_text_file(file, topic, layout, most_numbers)) out.push_back(std::move(table));
    return out;
  }
  const std::vector<TableDescription> tables = format.describe(request);
  const ImuTables chosen = topics.empty() ? imu_tables(format, request, tables) : ImuTables{topics, {}};
  for (const std::string& topic : chosen.names) {
    request.topic = find_table(tables, topic, file.string()).name;
    out.push_back(format.open_text != nullptr ? signals_of_text_table(format, request, tables.size() == 1, most_numbers)
                                              : signals_of(format, request, tables, most_numbers));
    leave_out_zeros(out.back());
  }
  out.front().notes.insert(out.front().notes.end(), chosen.notes.begin(), chosen.notes.end());
  return out;
}

std::vector<std::vector<std::string>> imus_of(const std::filesystem::path& file, const std::string& layout) {
  if (is_stream(file)) return {};
  const TableRequest request{file, "", layout};
  const RecordingFormat& format = format_of(request, recording_formats());
  if (format.is_text || format.open_text != nullptr) return {};
  return all_imus(format, request, format.describe(request));
}

SignalTable signals_of_text(const std::string& name, std::string_view bytes, const std::string& topic) {
  return std::move(tables_of_bytes(name, bytes, topic, "").front());
}

}  // namespace imulab
