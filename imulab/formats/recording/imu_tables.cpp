#include "imulab/formats/recording/imu_tables.hpp"

#include "imulab/core/text.hpp"
#include "imulab/error.hpp"
#include "imulab/formats/recording/table_reader.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/inspection/names.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

namespace imulab::recording_io {
namespace {

using inspection::NameHint;
using inspection::Role;
using Tables = std::vector<const TableDescription*>;

constexpr std::size_t far_more = 10;  // rows: two IMUs' rates differ by less

/// The columns of a sensor by axis, as a table's names tell them.
std::map<std::string, std::array<std::optional<std::size_t>, 3>> sensors_of(const TableDescription& table, Role role) {
  std::map<std::string, std::array<std::optional<std::size_t>, 3>> sensors;
  for (std::size_t i = 0; i < table.columns.size(); ++i) {
    const NameHint hint = inspection::hint_of(name_in_table(table.name, table.columns[i].name));
    if (hint.role == role && hint.axis >= 0) sensors[hint.sensor][static_cast<std::size_t>(hint.axis)] = i;
  }
  std::erase_if(sensors, [](const auto& sensor) { return !(sensor.second[0] && sensor.second[1] && sensor.second[2]); });
  return sensors;
}

/// True if three columns are named like a sensor's; with `axes`, like the three axes of one.
bool has_triad(const TableDescription& table, Role role, bool axes) {
  if (axes) return !sensors_of(table, role).empty();
  return std::count_if(table.columns.begin(), table.columns.end(), [&](const ColumnDescription& column) {
           return inspection::hint_of(name_in_table(table.name, column.name)).role == role;
         }) >= 3;
}

/// A reference that a data set has beside its readings: its columns are called like those of an IMU, whose biases it states.
bool is_reference(const TableDescription& table) {
  const std::string name = lowered(table.name);
  return name.find("truth") != std::string::npos || name.find("vicon") != std::string::npos || name.find("mocap") != std::string::npos;
}

Tables tables_with_triads(const std::vector<TableDescription>& tables, bool axes) {
  Tables named;
  for (const TableDescription& table : tables)
    if (!is_reference(table) && has_triad(table, Role::gyro, axes) && has_triad(table, Role::accel, axes)) named.push_back(&table);
  return named;
}

void sort_by_rows(Tables& tables) {
  std::stable_sort(tables.begin(), tables.end(), [](const TableDescription* a, const TableDescription* b) { return a->rows > b->rows; });
}

std::vector<std::string_view> names_of_tables(const Tables& tables) {
  std::vector<std::string_view> names;
  for (const TableDescription* table : tables) names.push_back(table->name);
  return names;
}

bool is_zero(const RawColumn& column) {
  return std::all_of(column.numbers.begin(), column.numbers.end(), [](double v) { return v == 0 || !std::isfinite(v); }) &&
         std::all_of(column.integers.begin(), column.integers.end(), [](std::int64_t v) { return v == 0; });
}

/// Whether a table's gyros and accelerometers have any reading that is not zero.
struct Readable {
  bool gyro = false, accel = false;
};

Readable readings_in(const RecordingFormat& format, const TableRequest& request, const TableDescription& table) {
  std::vector<Column> columns;
  std::size_t gyros = 0;
  for (const Role role : {Role::gyro, Role::accel}) {
    for (const auto& [name, axes] : sensors_of(table, role))
      for (const auto& axis : axes) columns.emplace_back(static_cast<int>(axis.value()) + 1);
    if (role == Role::gyro) gyros = columns.size();
  }
  TableRequest own = request;
  own.topic = table.name;
  expect_memory_for(request.file.string(), table.rows, columns.size(), 1);
  Readable found;
  try {
    format.read(own, {.columns = columns, .in_pieces = format.in_pieces}, [&](TableRows&& piece) {
      for (std::size_t c = 0; c < columns.size(); ++c)
        if (!is_zero(piece.columns[c])) (c < gyros ? found.gyro : found.accel) = true;
      return !(found.gyro && found.accel);
    });
  } catch (const Error&) {  // what is wrong with it is said when it is the one that is read
    return {true, true};
  }
  return found;
}

std::string zeros_note(const std::string& name, Readable readings) {
  return fmt::format("{}: {} zero in every row: {}", name,
                     !readings.gyro && !readings.accel ? "gyros and accelerometers are"
                     : readings.gyro                   ? "the accelerometers are"
                                                       : "the gyros are",
                     "that topic was not taken for them");
}

[[noreturn]] void expect_one(const TableRequest& request, const std::vector<std::string>& names) {
  throw Error(fmt::format("{}: several tables have both gyros and accelerometers by name; expected a topic of {}", request.file.string(),
                          text::listed_excerpts(names)));
}

/// Of tables named like an IMU's, of which none has far more rows than the others, those with readings. Nothing where they do not decide.
std::optional<ImuTables> by_readings(const RecordingFormat& format, const TableRequest& request, const Tables& named) {
  constexpr std::size_t most_read = 8;
  if (named.size() > most_read) return std::nullopt;
  ImuTables both, split;
  Tables gyros, accels;
  for (const TableDescription* table : named) {
    const Readable readings = readings_in(format, request, *table);
    if (readings.gyro && readings.accel) {
      both.names.push_back(table->name);
      continue;
    }
    if (readings.gyro) gyros.push_back(table);
    if (readings.accel) accels.push_back(table);
    both.notes.push_back(zeros_note(table->name, readings));
  }
  if (both.names.size() == 1) return both;
  if (both.names.size() > 1) expect_one(request, both.names);
  if (gyros.size() != 1 || accels.size() != 1) return std::nullopt;
  return ImuTables{{gyros.front()->name, accels.front()->name}, both.notes};
}

/// How well a table's name says that it holds what a sensor measures: apps of phones also give it without gravity, and before their own calibration.
int rank_of(const TableDescription& table) {
  const std::string name = lowered(table.name);
  const auto has = [&](std::string_view word) { return name.find(word) != std::string::npos; };
  const bool linear = has("linear") || has("gravity") || has("user");
  return linear ? 0 : has("uncalibrated") ? 1 : has("total") ? 3 : 2;
}

/// The table of one sensor alone; null where none, or several, may be meant.
const TableDescription* table_of_sensor(const std::vector<TableDescription>& tables, Role role, std::vector<std::string>& notes) {
  Tables found;
  for (const TableDescription& table : tables)
    if (!is_reference(table) && has_triad(table, role, true) && rank_of(table) > 0) found.push_back(&table);
  sort_by_rows(found);
  std::stable_sort(found.begin(), found.end(), [](const TableDescription* a, const TableDescription* b) { return rank_of(*a) > rank_of(*b); });
  if (found.empty()) return nullptr;
  const bool clear = found.size() == 1 || rank_of(*found[0]) > rank_of(*found[1]) || found[0]->rows / far_more >= found[1]->rows;
  if (!clear) return nullptr;
  if (found.size() > 1)
    notes.push_back(fmt::format("{} was taken for the {}; --topic takes others: {}", found[0]->name, role == Role::gyro ? "gyros" : "accelerometers",
                                fmt::join(names_of_tables({found.begin() + 1, found.end()}), ", ")));
  return found.front();
}

}  // namespace

ImuTables imu_tables(const RecordingFormat& format, const TableRequest& request, const std::vector<TableDescription>& tables) {
  const std::string file = request.file.string();
  if (tables.size() < 2) return {{find_table(tables, "", file).name}, {}};
  Tables named = tables_with_triads(tables, true);
  if (named.empty()) named = tables_with_triads(tables, false);
  sort_by_rows(named);
  if (named.size() == 1) return {{named.front()->name}, {}};
  if (named.size() > 1) {
    if (named[0]->rows / far_more >= named[1]->rows)
      return {{named[0]->name},
              {fmt::format("{} has most rows of the tables with gyros and accelerometers and was taken; --topic takes another: {}", named[0]->name,
                           text::listed(names_of_tables({named.begin() + 1, named.end()})))}};
    if (auto chosen = by_readings(format, request, named)) return *std::move(chosen);
    std::vector<std::string> names;
    for (const TableDescription* table : named) names.push_back(table->name);
    expect_one(request, names);
  }
  ImuTables out;
  const TableDescription* gyro = table_of_sensor(tables, Role::gyro, out.notes);
  const TableDescription* accel = table_of_sensor(tables, Role::accel, out.notes);
  if (gyro != nullptr && accel != nullptr && gyro != accel) {
    out.names = {gyro->name, accel->name};
    return out;
  }
  std::vector<std::string> names;
  for (const TableDescription& table : tables) names.push_back(table.name);
  throw Error(fmt::format("{}: no table has both gyros and accelerometers by name; expected a topic of {} (--topic, once for each of two)", file,
                          text::listed_excerpts(names)));
}

namespace {

/// A table's name without the word of its sensor: "sensor_.1" of sensor_gyro.1.
std::string without_sensor(const TableDescription& table) {
  std::string name = lowered(table.name);
  for (const std::string_view word : {"accelerometer", "gyroscope", "accel", "gyro", "acc", "gyr"})
    if (const std::size_t at = name.find(word); at != std::string::npos) return name.erase(at, word.size());
  return name;
}

}  // namespace

std::vector<std::vector<std::string>> all_imus(const RecordingFormat& format, const TableRequest& request,
                                               const std::vector<TableDescription>& tables) {
  constexpr std::size_t most_read = 16, most_times = 2;  // rows: of a table that joins one gyro and one accelerometer, over those of each
  struct Unit {
    std::vector<std::string> tables;
    const TableDescription* first;
    std::size_t rows;
  };
  std::vector<Unit> whole, halves;
  Tables gyros, accels;
  for (const TableDescription& table : tables) {
    if (is_reference(table) || rank_of(table) == 0) continue;
    const bool gyro = has_triad(table, Role::gyro, true), accel = has_triad(table, Role::accel, true);
    if (gyro && accel) whole.push_back({{table.name}, &table, table.rows});
    if (gyro != accel) (gyro ? gyros : accels).push_back(&table);
  }
  for (const TableDescription* gyro : gyros)
    for (const TableDescription* accel : accels)
      if (without_sensor(*gyro) == without_sensor(*accel)) halves.push_back({{gyro->name, accel->name}, gyro, std::min(gyro->rows, accel->rows)});
  const auto most_rows = [](const std::vector<Unit>& units) { return units.empty() ? 0 : std::ranges::max_element(units, {}, &Unit::rows)->rows; };
  std::vector<Unit>& units = halves.size() > 1 && most_times * most_rows(halves) >= most_rows(whole) ? halves : whole;
  if (units.empty()) return {};
  // Beside its IMUs a log may have a table of their health, or of averages, with other columns.
  const Unit most = *std::ranges::max_element(units, {}, &Unit::rows);
  std::erase_if(units, [&](const Unit& unit) {
    return unit.rows <= most.rows / far_more ||
           !std::ranges::equal(unit.first->columns, most.first->columns, {}, &ColumnDescription::name, &ColumnDescription::name);
  });
  if (units.size() < 2 || units.size() > most_read) return {};
  std::vector<std::vector<std::string>> out;
  for (const Unit& unit : units) {
    const Readable read = readings_in(format, request, *unit.first);
    if (read.gyro && (read.accel || unit.tables.size() > 1)) out.push_back(unit.tables);
  }
  return out.size() > 1 ? out : std::vector<std::vector<std::string>>{};
}

std::string name_in_table(const std::string& table, const std::string& name) {
  const NameHint column = inspection::hint_of(name);
  const Role sensor = inspection::hint_of(table).role;
  const bool adds = column.role == Role::unknown && column.axis >= 0 && (sensor == Role::gyro || sensor == Role::accel);
  return adds ? table + "." + name : name;
}

void leave_out_zeros(SignalTable& table) {
  std::map<Role, std::map<std::string, std::vector<std::size_t>>> sensors;
  for (std::size_t i = 0; i < table.signals.size(); ++i) {
    const NameHint hint = inspection::hint_of(table.signals[i].name);
    if ((hint.role == Role::gyro || hint.role == Role::accel) && hint.axis >= 0) sensors[hint.role][hint.sensor].push_back(i);
  }
  if (sensors.size() < 2) return;  // of one sensor alone the zeros are what there is
  std::set<std::size_t> left_out;
  for (const auto& [role, of_role] : sensors)
    for (const auto& [name, columns] : of_role) {
      const bool zeros = std::all_of(columns.begin(), columns.end(), [&](std::size_t i) {
        const std::vector<double>& values = table.signals[i].values;
        return std::all_of(values.begin(), values.end(), [](double v) { return v == 0; });
      });
      if (columns.size() != 3 || !zeros || table.rows() == 0) continue;
      left_out.insert(columns.begin(), columns.end());
      table.notes.push_back(fmt::format("{}, {}, {} are zero in every row and were left out", table.signals[columns[0]].name,
                                        table.signals[columns[1]].name, table.signals[columns[2]].name));
    }
  std::size_t at = 0;
  std::erase_if(table.signals, [&](const Signal&) { return left_out.contains(at++); });
}

}  // namespace imulab::recording_io
