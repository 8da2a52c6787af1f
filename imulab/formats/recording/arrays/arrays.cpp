#include "imulab/formats/recording/arrays/arrays.hpp"

#include "imulab/core/text.hpp"

#include <algorithm>
#include <array>
#include <string_view>

namespace imulab::recording_io {

ArrayShape table_shape(const std::vector<std::size_t>& dimensions, bool last_runs_fastest) {
  if (dimensions.size() == 1) return {dimensions[0], 1, false};
  const bool lying = dimensions[0] < dimensions[1];  // 3 x N
  return {std::max(dimensions[0], dimensions[1]), std::min(dimensions[0], dimensions[1]), lying == last_runs_fastest};
}

std::vector<ColumnDescription> column_names(const std::string& name, std::size_t columns, const std::string& unit) {
  std::vector<ColumnDescription> names;
  names.reserve(columns);
  const std::string before = name.empty() ? "" : name + ".";
  if (columns == 1 && !name.empty()) return {{name, unit}};
  for (std::size_t i = 1; i <= columns; ++i) names.push_back({before + std::to_string(i), unit});
  return names;
}

bool names_rate(const std::string& name) {
  static constexpr std::array<std::string_view, 9> names{
      "fs", "fshz", "samplerate", "sampleratehz", "samplingrate", "samplingratehz", "samplingfrequency", "samplefrequency", "ratehz"};
  std::string key = lowered(name.substr(name.find_last_of("/.") + 1));  // npos + 1 is 0
  std::erase_if(key, [](char c) { return c == '_' || c == ' '; });
  return std::find(names.begin(), names.end(), key) != names.end();
}

namespace {

bool is_rate(const NumberArray& array) { return array.rows == 1 && array.columns.size() == 1 && names_rate(array.name); }

}  // namespace

std::vector<ArrayTable> tables_of(const std::vector<NumberArray>& arrays) {
  const bool has_samples = std::any_of(arrays.begin(), arrays.end(), [](const NumberArray& a) { return a.rows > 1; });
  std::vector<ArrayTable> tables;
  for (std::size_t a = 0; a < arrays.size(); ++a) {
    const NumberArray& array = arrays[a];
    if (array.rows == 0 || (has_samples && array.rows == 1)) continue;
    auto table = std::find_if(tables.begin(), tables.end(), [&](const ArrayTable& t) { return t.description.rows == array.rows; });
    if (table == tables.end()) {
      table = tables.insert(tables.end(), ArrayTable{});
      table->description.name = array.name;
      table->description.rows = array.rows;
    }
    if (!array.name.empty()) table->description.other_names.push_back(array.name);
    for (std::size_t c = 0; c < array.columns.size(); ++c) {
      table->description.columns.push_back(array.columns[c]);
      table->places.push_back({a, c});
    }
  }
  if (tables.size() == 1) tables.front().description.name.clear();
  for (const NumberArray& array : arrays)
    if (is_rate(array))
      for (ArrayTable& table : tables)
        if (table.description.rows > 1) table.description.other_names.push_back(array.name);
  return tables;
}

std::vector<TableDescription> descriptions_of(const std::vector<NumberArray>& arrays) {
  std::vector<TableDescription> descriptions;
  for (ArrayTable& table : tables_of(arrays)) descriptions.push_back(std::move(table.description));
  return descriptions;
}

std::vector<ArrayColumn> find_array_columns(const std::vector<NumberArray>& arrays, const std::string& topic, const std::vector<Column>& columns,
                                            const std::string& file) {
  for (std::size_t a = 0; a < arrays.size(); ++a)
    if (is_rate(arrays[a]) && arrays[a].name == topic && columns.size() == 1) return {{a, 0}};
  const std::vector<ArrayTable> tables = tables_of(arrays);
  const std::vector<TableDescription> descriptions = descriptions_of(arrays);
  const ArrayTable& table = tables[static_cast<std::size_t>(&find_table(descriptions, topic, file) - descriptions.data())];
  std::vector<ArrayColumn> places;
  for (const Column& column : columns) places.push_back(table.places[find_column(table.description, column, file)]);
  return places;
}

}  // namespace imulab::recording_io
