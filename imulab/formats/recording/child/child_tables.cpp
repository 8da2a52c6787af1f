#include "imulab/formats/recording/child/child_tables.hpp"

#include "imulab/error.hpp"
#include "imulab/formats/text/reading_meter.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <optional>
#include <string>

namespace imulab::recording_io {
namespace {

void receive_tables(FromChild& from, std::vector<TableDescription>& tables) {
  tables.resize(from.count(sizeof(TableDescription)));
  for (TableDescription& table : tables) {
    table.name = from.text();
    table.type = from.text();
    table.rows = static_cast<std::size_t>(from.number());
    table.columns.resize(from.count(sizeof(ColumnDescription)));
    for (ColumnDescription& column : table.columns) column.name = from.text(), column.unit = from.text();
    table.other_names.resize(from.count(sizeof(std::string)));
    for (std::string& name : table.other_names) name = from.text();
  }
}

template <class Number>
void send_numbers(ToParent& to, const std::vector<Number>& numbers) {
  to.number(numbers.size());
  to.bytes(numbers.data(), numbers.size() * sizeof(Number));
}

template <class Number>
std::size_t receive_numbers(FromChild& from, std::vector<Number>& numbers, std::size_t all, std::size_t room) {
  if (numbers.empty()) numbers.reserve(all);
  const std::size_t more = from.count(sizeof(Number));
  if (more > room) from.reject();
  from.parts(more * sizeof(Number), [&](const char* part, std::size_t bytes) {
    const auto* const first = reinterpret_cast<const Number*>(part);
    numbers.insert(numbers.end(), first, first + bytes / sizeof(Number));
  });
  return more;
}

/// Rows of one of `columns`, which have `all` rows, as the first part says: how many came. The columns of integers with numbers too large for them
/// become numbers.
std::size_t receive_rows(FromChild& from, RawColumn& column, std::size_t columns, std::optional<std::size_t>& all) {
  const bool integers = from.number() == 0;
  if (!all)
    all = from.most(columns * sizeof(double));
  else if (from.number() != *all)
    from.reject();
  const std::size_t room = *all - column.size();
  if (integers) {
    const std::size_t rows = receive_numbers(from, column.integers, *all, room);
    if (rows > 0 && !column.numbers.empty()) column.make_numbers();
    return rows;
  }
  column.make_numbers();
  return receive_numbers(from, column.numbers, *all, room);
}

}  // namespace

std::vector<TableDescription> describe_in_child(const ChildTask& task, const StartChild& start) {
  std::vector<TableDescription> tables;
  run_in_child(task, start, [&](FromChild& from) { receive_tables(from, tables); });
  return tables;
}

void send_tables(ToParent& to, const std::vector<TableDescription>& tables) {
  to.next();
  to.number(tables.size());
  for (const TableDescription& table : tables) {
    to.text(table.name);
    to.text(table.type);
    to.number(table.rows);
    to.number(table.columns.size());
    for (const ColumnDescription& column : table.columns) to.text(column.name), to.text(column.unit);
    to.number(table.other_names.size());
    for (const std::string& name : table.other_names) to.text(name);
  }
}

TableRows columns_in_child(const ChildTask& task, std::size_t columns, const StartChild& start) {
  TableRows table;
  table.columns.resize(columns);
  std::optional<std::size_t> all;
  std::optional<ReadingMeter> meter;
  run_in_child(task, start, [&](FromChild& from) {
    const std::uint64_t index = from.number();
    if (index >= columns) from.reject();
    const std::size_t rows = receive_rows(from, table.columns[index], columns, all);
    if (!meter) meter.emplace(columns * *all);
    meter->add(rows);
  });
  if (std::any_of(table.columns.begin(), table.columns.end(), [&](const RawColumn& c) { return c.size() != all.value_or(0); }))
    throw Error(fmt::format("{}: is damaged: {} failed on it (rows are missing); expected a whole file", task.file.string(), task.library));
  return table;
}

SendColumn column_sender(ToParent& to) {
  return [&to](std::size_t index, const RawColumn& rows, std::size_t all) {
    to.next();
    to.number(index);
    to.number(rows.numbers.empty() ? 0 : 1);
    to.number(all);
    if (rows.numbers.empty())
      send_numbers(to, rows.integers);
    else
      send_numbers(to, rows.numbers);
  };
}

void send_rows(const std::vector<NumberField>& fields, const char* first, std::size_t stride, std::size_t count, const SendRows& send) {
  ColumnBuilder builder(fields, count);
  builder.add(first, stride, count);
  const std::vector<RawColumn> columns = builder.take();
  for (std::size_t k = 0; k < columns.size(); ++k) send.column(send.to[k], columns[k], send.rows);
}

}  // namespace imulab::recording_io
