// Receivers and barometers in the logs of autopilots: PX4's ULog (vehicle_gps_position, vehicle_air_data; their .msg files) and ArduPilot's DataFlash
// (GPS and GPA, BARO; https://ardupilot.org/copter/docs/logmessages.html).
#include "imulab/error.hpp"
#include "imulab/formats/aid/format.hpp"
#include "imulab/formats/recording/format.hpp"
#include "imulab/formats/recording/table_reader.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/units.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <utility>

namespace imulab::aid_io {
namespace {

using recording_io::TableDescription;
using recording_io::TableRows;

/// A message of a log, and one that has more of the same stamps. `put` gets their numbers in the order of the names, NaN for those that are not
/// there; false without a fix.
struct LogSource {
  AidKind kind;
  std::string_view message;
  std::vector<std::string_view> time;  ///< the first that is there [us]
  std::vector<std::string_view> columns;
  std::string_view beside;
  std::vector<std::string_view> columns_beside;
  bool (*put)(std::span<const double> v, AidRow& row);
};

double first_of(double a, double b) { return std::isnan(a) ? b : a; }

bool put_px4_gps(std::span<const double> v, AidRow& row) {
  constexpr double three_dimensions = 3;  // fix_type
  row.position = {first_of(v[0], 1e-7 * v[3]) * unit::deg, first_of(v[1], 1e-7 * v[4]) * unit::deg, first_of(v[2], 1e-3 * v[5])};
  row.velocity = {v[6], v[7], -v[8]};
  row.position_sigma = {v[9], v[9], v[10]};
  row.velocity_sigma.setConstant(v[11]);
  return !(v[12] < three_dimensions);
}

bool put_ardupilot_gps(std::span<const double> v, AidRow& row) {
  constexpr double three_dimensions = 3;  // Status
  row.position = {v[0] * unit::deg, v[1] * unit::deg, v[2] + v[10]};
  row.velocity = {v[3] * std::sin(v[4] * unit::deg), v[3] * std::cos(v[4] * unit::deg), -v[5]};
  row.position_sigma = {v[7], v[7], v[8]};
  row.velocity_sigma.setConstant(v[9]);
  if (std::isnan(v[10])) row.position.z() = v[2];
  return !(v[6] < three_dimensions);
}

bool put_height(std::span<const double> v, AidRow& row) {
  row.value = v[0];
  return true;
}

const std::vector<LogSource>& log_sources() {
  static const std::vector<LogSource> sources{
      {AidKind::gnss,
       "vehicle_gps_position",
       {"timestamp_sample", "timestamp"},
       {"latitude_deg", "longitude_deg", "altitude_ellipsoid_m", "lat", "lon", "alt_ellipsoid", "vel_e_m_s", "vel_n_m_s", "vel_d_m_s", "eph", "epv",
        "s_variance_m_s", "fix_type"},
       "",
       {},
       put_px4_gps},
      {AidKind::barometer, "vehicle_air_data", {"timestamp_sample", "timestamp"}, {"baro_alt_meter"}, "", {}, put_height},
      {AidKind::gnss,
       "GPS",
       {"TimeUS"},
       {"Lat", "Lng", "Alt", "Spd", "GCrs", "VZ", "Status"},
       "GPA",
       {"HAcc", "VAcc", "SAcc", "Und"},
       put_ardupilot_gps},
      {AidKind::barometer, "BARO", {"TimeUS"}, {"Alt"}, "", {}, put_height},
  };
  return sources;
}

/// "GPS" of "GPS.1"
std::string_view message_of(std::string_view table) { return table.substr(0, table.find('.')); }

const TableDescription* table_of(const std::vector<TableDescription>& tables, std::string_view name) {
  const auto found = std::find_if(tables.begin(), tables.end(), [&](const TableDescription& t) { return t.name == name; });
  return found != tables.end() ? &*found : nullptr;
}

bool has_column(const TableDescription& table, std::string_view name) {
  return std::any_of(table.columns.begin(), table.columns.end(), [&](const auto& column) { return column.name == name; });
}

/// Numbers of a table: the time, then the columns, NaN for those that are not there.
struct LogNumbers {
  std::vector<std::int64_t> time_us;
  std::vector<std::vector<double>> columns;
  std::vector<std::string> warnings;
};

LogNumbers numbers_of(const std::filesystem::path& file, const TableDescription& table, const LogSource& source,
                      const std::vector<std::string_view>& names) {
  const auto time = std::find_if(source.time.begin(), source.time.end(), [&](std::string_view name) { return has_column(table, name); });
  if (time == source.time.end()) throw Error(fmt::format("{}: {} has no {}; expected its time", input_name(file), table.name, source.time.back()));
  std::vector<Column> wanted{std::string(*time)};
  for (const std::string_view name : names)
    if (has_column(table, name)) wanted.emplace_back(std::string(name));
  TableRows rows = recording_io::read_columns({.file = file, .topic = table.name}, wanted);
  LogNumbers out{std::move(rows.columns[0].integers), {}, std::move(rows.warnings)};
  for (const double us : rows.columns[0].numbers) out.time_us.push_back(std::abs(us) < 1e15 ? std::llround(us) : 0);
  std::size_t next = 1;
  for (const std::string_view name : names) {
    std::vector<double>& column = out.columns.emplace_back();
    if (!has_column(table, name)) {
      column.assign(out.time_us.size(), AidRow::none);
      continue;
    }
    column = std::move(rows.columns[next].numbers);
    column.insert(column.end(), rows.columns[next].integers.begin(), rows.columns[next].integers.end());
    ++next;
  }
  return out;
}

/// Throws Error that names what there is.
std::pair<const LogSource*, const TableDescription*> choose(const std::vector<TableDescription>& tables, const AidRequest& request) {
  std::vector<std::string_view> expected;
  for (const LogSource& source : log_sources()) {
    if (source.kind != request.kind) continue;
    expected.push_back(source.message);
    if (!request.topic.empty() && message_of(request.topic) != source.message) continue;
    if (const TableDescription* table = table_of(tables, request.topic.empty() ? source.message : std::string_view(request.topic)))
      return {&source, table};
  }
  std::vector<std::string> names;
  for (const TableDescription& table : tables) names.push_back(table.name);
  throw Error(fmt::format("{}: has no {} of kind {}; expected {}; it has {}", input_name(request.file),
                          request.topic.empty() ? "message" : excerpt(request.topic), to_string(request.kind),
                          expected.empty() ? "an aid of another kind" : text::listed(expected), text::listed_excerpts(names)));
}

AidRows read_log(const AidRequest& request) {
  const TableRequest log{.file = request.file};
  const std::vector<TableDescription> tables = format_of(log).describe(log);
  const auto [source, table] = choose(tables, request);
  LogNumbers numbers = numbers_of(request.file, *table, *source, source->columns);
  std::map<std::int64_t, std::vector<double>> beside;  // by time
  const std::string suffix = table->name.substr(source->message.size());
  if (const TableDescription* other = source->beside.empty() ? nullptr : table_of(tables, std::string(source->beside) + suffix)) {
    const LogNumbers more = numbers_of(request.file, *other, *source, source->columns_beside);
    for (std::size_t i = 0; i < more.time_us.size(); ++i)
      for (const std::vector<double>& column : more.columns) beside[more.time_us[i]].push_back(column[i]);
  }
  AidRows out{.file = input_name(request.file), .row = table->name, .warnings = std::move(numbers.warnings)};
  const std::vector<double> nothing(source->columns_beside.size(), AidRow::none);
  std::size_t without_fix = 0;
  for (std::size_t i = 0; i < numbers.time_us.size(); ++i) {
    if (std::abs(numbers.time_us[i]) > 4'000'000'000'000'000) continue;  // 127 years: damaged
    std::vector<double> values;
    for (const std::vector<double>& column : numbers.columns) values.push_back(column[i]);
    const auto more = beside.find(numbers.time_us[i]);
    const std::vector<double>& others = more != beside.end() ? more->second : nothing;
    values.insert(values.end(), others.begin(), others.begin() + static_cast<std::ptrdiff_t>(nothing.size()));
    AidRow row;
    row.time = numbers.time_us[i] * 1000, row.line = i + 1;
    if (source->put(values, row))
      out.rows.push_back(row);
    else
      ++without_fix;
  }
  if (without_fix > 0) out.warnings.push_back(fmt::format("{}: {}: {} messages without a fix are left out", out.file, table->name, without_fix));
  if (source->message != "GPS" || !beside.empty()) return out;
  std::ranges::for_each(out.rows, widen_by_geoid);
  out.warnings.push_back(out.file + ": its heights are above sea level (no message GPA): up to 100 m from the ellipsoid");
  return out;
}

}  // namespace

AidFormat ulog_aid_format() { return {"PX4 ULog", recording_io::ulog_format().recognizes, read_log, true}; }
AidFormat dataflash_aid_format() { return {"ArduPilot DataFlash", recording_io::dataflash_format().recognizes, read_log, true}; }

}  // namespace imulab::aid_io
