#include "imulab/io/recording/csv.hpp"

#include "imulab/io/recording/csv_rows.hpp"
#include "imulab/io/recording/format.hpp"
#include "imulab/io/text/file.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

namespace imulab::recording_io {
namespace {

void reserve(TimedTable& table, std::string_view rows) {
  const std::string_view head = rows.substr(0, 1 << 16);
  const auto lines = static_cast<std::size_t>(std::count(head.begin(), head.end(), '\n')) + 1;
  const std::size_t estimate = rows.size() / (head.size() / lines + 1) * 21 / 20 + 16;  // pages never touched cost nothing
  table.time_ns.reserve(estimate);
  for (auto& column : table.values) column.reserve(estimate);
}

}  // namespace

bool is_text(std::string_view head) { return head.find('\0') == std::string_view::npos; }

TimedTable read_csv(const std::filesystem::path& path, const TimeSource& time, std::optional<double> rate_hz, const std::vector<Column>& columns) {
  const MappedFile file(path);
  const TableLayout layout = table_layout(path.string(), file.text(), names_a_column(time, columns));
  std::string_view text = file.text().substr(layout.offset);
  RowReader reader(layout, time, rate_hz, columns);

  TimedTable table;
  table.file = path.string();
  table.values.resize(reader.row().values.size());
  reserve(table, text);
  while (reader.next(text)) {
    table.lines.add(table.time_ns.size(), reader.line());
    table.time_ns.push_back(reader.row().time_ns);
    for (std::size_t k = 0; k < table.values.size(); ++k) table.values[k].push_back(reader.row().values[k]);
  }
  table.repeated = reader.repeated();
  if (layout.skipped > 0)
    table.warnings.push_back(fmt::format("{}: {} line{} of other text before the table passed over", table.file, layout.skipped,
                                         layout.skipped == 1 ? "" : "s"));

  const std::vector<std::size_t>& places = reader.places();
  std::vector<std::vector<double>> values(places.size());
  for (std::size_t i = places.size(); i-- > 0;) {
    const auto end = places.begin() + static_cast<std::ptrdiff_t>(i);
    const bool again = std::find(places.begin(), end, places[i]) != end;
    values[i] = again ? table.values[places[i]] : std::move(table.values[places[i]]);
  }
  table.values = std::move(values);
  return table;
}

std::vector<TableDescription> describe_text(const TableRequest& request) {
  const MappedFile file(request.file);
  const TableLayout layout = table_layout(request.file.string(), file.text(), false);
  TableDescription table;
  for (std::size_t i = 0; i < layout.columns; ++i) table.columns.push_back({layout.column_name(i)});
  const std::string_view rows = file.text().substr(layout.offset);
  table.rows = static_cast<std::size_t>(std::count(rows.begin(), rows.end(), '\n')) + !rows.ends_with('\n');
  return {table};
}

RawTable text_columns(const TableRequest& request, const std::vector<Column>& columns) {
  TimedTable table = read_csv(request.file, {.column = std::nullopt}, 1, columns);
  RawTable raw;
  raw.row = "line";
  for (auto& column : table.values) raw.columns.push_back({std::move(column), {}});
  return raw;
}

}  // namespace imulab::recording_io
