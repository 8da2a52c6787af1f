#include "imulab/formats/recording/text/csv.hpp"

#include "imulab/error.hpp"
#include "imulab/formats/aid/format.hpp"
#include "imulab/formats/recording/format.hpp"
#include "imulab/formats/text/decimal.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/inspection/names.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

namespace imulab::aid_io {
namespace {

/// One number of a row: its column, its unit, and where it is.
struct AidColumn {
  std::string_view name;
  double factor;
  double& (*in)(AidRow& row);
  bool is_sigma = false;
};

template <Eigen::Vector3d AidRow::*Vector, int I>
double& part(AidRow& row) {
  return (row.*Vector)[I];
}

template <int I>
double& quaternion(AidRow& row) {
  return row.attitude[I];
}

double& value_of(AidRow& row) { return row.value; }
double& value_sigma_of(AidRow& row) { return row.value_sigma; }

/// Columns that a file has all together or not at all; one that begins with a measurement must be there.
using AidColumns = std::vector<AidColumn>;

std::vector<AidColumns> value_columns(std::string_view name, std::string_view sigma, double factor) {
  return {{{name, factor, value_of}}, {{sigma, factor, value_sigma_of, true}}};
}

/// Columns of poses and attitudes; the first group that a kind must have comes first.
std::vector<AidColumns> pose_columns(AidKind kind) {
  std::vector<AidColumns> out{{{"qw", 1, quaternion<3>}, {"qx", 1, quaternion<0>}, {"qy", 1, quaternion<1>}, {"qz", 1, quaternion<2>}},
                              {{"attitude_sigma_deg", unit::deg, value_sigma_of, true}}};
  if (kind == AidKind::attitude) return out;
  out.push_back({{"x_m", 1, part<&AidRow::place, 0>}, {"y_m", 1, part<&AidRow::place, 1>}, {"z_m", 1, part<&AidRow::place, 2>}});
  out.push_back({{"x_sigma_m", 1, part<&AidRow::position_sigma, 0>, true},
                 {"y_sigma_m", 1, part<&AidRow::position_sigma, 1>, true},
                 {"z_sigma_m", 1, part<&AidRow::position_sigma, 2>, true}});
  return out;
}

std::vector<AidColumns> aid_columns(AidKind kind) {
  switch (kind) {
    case AidKind::pose:
    case AidKind::attitude:
    case AidKind::odometry:
      return pose_columns(kind);
    case AidKind::wheels:
      return value_columns("speed_mps", "speed_sigma_mps", 1);
    case AidKind::barometer:
      return value_columns("height_m", "height_sigma_m", 1);
    case AidKind::heading:
      return value_columns("heading_deg", "heading_sigma_deg", unit::deg);
    case AidKind::gnss:
    case AidKind::vehicle:
    case AidKind::zero_velocity:
      break;
  }
  return {
      {{"latitude_deg", unit::deg, part<&AidRow::position, 0>},
       {"longitude_deg", unit::deg, part<&AidRow::position, 1>},
       {"height_m", 1, part<&AidRow::position, 2>}},
      {{"east_sigma_m", 1, part<&AidRow::position_sigma, 0>, true},
       {"north_sigma_m", 1, part<&AidRow::position_sigma, 1>, true},
       {"up_sigma_m", 1, part<&AidRow::position_sigma, 2>, true}},
      {{"ve", 1, part<&AidRow::velocity, 0>}, {"vn", 1, part<&AidRow::velocity, 1>}, {"vu", 1, part<&AidRow::velocity, 2>}},
      {{"ve_sigma", 1, part<&AidRow::velocity_sigma, 0>, true},
       {"vn_sigma", 1, part<&AidRow::velocity_sigma, 1>, true},
       {"vu_sigma", 1, part<&AidRow::velocity_sigma, 2>, true}},
  };
}

/// Where the stamps of a file count from.
struct AidTimeColumn {
  std::string_view name;
  TimeScale scale;
  std::int64_t ahead_ns;
};
constexpr std::array<AidTimeColumn, 3> time_columns{
    {{"t", TimeScale::recording, 0}, {"gps_s", TimeScale::gps, gps_epoch_ns}, {"utc_s", TimeScale::utc, 0}}};

std::string listed_columns(const AidColumns& columns) {
  std::vector<std::string_view> names;
  for (const AidColumn& column : columns) names.push_back(column.name);
  return text::listed(names);
}

bool is_among(std::string_view name, const std::vector<std::string>& names) { return std::find(names.begin(), names.end(), name) != names.end(); }

const AidTimeColumn* time_column_in(const std::vector<std::string>& names) {
  return std::find_if(time_columns.begin(), time_columns.end(), [&](const AidTimeColumn& t) { return is_among(t.name, names); });
}

std::vector<std::string> names_of_columns(const std::filesystem::path& file) {
  std::vector<std::string> names;
  const std::vector<recording_io::TableDescription> tables = recording_io::text_format().describe({file});
  for (const recording_io::ColumnDescription& column : tables.front().columns) names.push_back(column.name);
  return names;
}

/// The columns of the kind that the file has.
AidColumns columns_there(const std::vector<std::string>& names, AidKind kind, const std::string& file) {
  AidColumns there;
  std::string expected;
  bool measures = false;
  const std::vector<AidColumns> groups = aid_columns(kind);
  for (const AidColumns& group : groups) {
    const auto count = std::count_if(group.begin(), group.end(), [&](const AidColumn& c) { return is_among(c.name, names); });
    if (count > 0 && count < static_cast<std::ptrdiff_t>(group.size()))
      throw Error(fmt::format("{}: has some of the columns {}; expected all of them, or none", file, listed_columns(group)));
    if (count > 0) there.insert(there.end(), group.begin(), group.end());
    if (!group.front().is_sigma) expected += (expected.empty() ? "" : has_attitude(kind) ? ", and " : ", or ") + listed_columns(group);
    if (!group.front().is_sigma) measures = has_attitude(kind) ? (count > 0 && (measures || &group == &groups.front())) : measures || count > 0;
  }
  if (!measures) throw Error(fmt::format("{}: has no column of an aid of kind {}; expected {}", file, to_string(kind), expected));
  return there;
}

AidRows read_aid_csv(const AidRequest& request) {
  const std::string file = input_name(request.file);
  const std::vector<std::string> names = names_of_columns(request.file);
  const AidColumns columns = columns_there(names, request.kind, file);
  const AidTimeColumn* const time = time_column_in(names);
  if (time == time_columns.end())
    throw Error(file + ": has no column of time; expected t (s of the recording's clock), gps_s (s of GPS time since 1980) or utc_s (since 1970)");
  std::vector<Column> wanted;
  for (const AidColumn& column : columns) wanted.emplace_back(std::string(column.name));
  recording_io::TableRows table = recording_io::read_csv(request.file, {.column = std::string(time->name)}, std::nullopt, wanted);
  AidRows out{.file = file, .scale = time->scale, .warnings = std::move(table.warnings)};
  for (std::size_t i = 0; i < table.time_ns.size(); ++i) {
    AidRow& row = out.rows.emplace_back();
    row.time = table.time_ns[i] + time->ahead_ns;
    row.line = table.lines[i];
    for (std::size_t c = 0; c < columns.size(); ++c) columns[c].in(row) = table.columns[c].numbers[i] * columns[c].factor;
  }
  return out;
}

bool may_be_csv(std::string_view head) { return head.find('\0') == std::string_view::npos; }

AidRow row_of(const AidRecord& record, std::size_t i) {
  AidRow row;
  if (!record.position.empty()) row.position = record.position[i];
  if (!record.position_sigma.empty()) row.position_sigma = record.position_sigma[i];
  if (!record.velocity.empty()) row.velocity = record.velocity[i];
  if (!record.velocity_sigma.empty()) row.velocity_sigma = record.velocity_sigma[i];
  if (!record.value.empty()) row.value = record.value[i];
  if (!record.value_sigma.empty()) row.value_sigma = record.value_sigma[i];
  if (!record.place.empty()) row.place = record.place[i];
  if (!record.attitude.empty()) row.attitude = record.attitude[i];
  return row;
}

}  // namespace

std::string aid_csv(const Aid& aid, std::string_view comment) {
  std::string text = fmt::format("# {}\nt", comment);
  AidColumns columns;
  AidRow first = row_of(aid.record, 0);
  for (const AidColumns& group : aid_columns(aid.kind))
    for (const AidColumn& column : group)
      if (!std::isnan(column.in(first))) columns.push_back(column), text.append(",").append(column.name);
  text += '\n';
  for (std::size_t i = 0; i < aid.record.time.size(); ++i) {
    AidRow row = row_of(aid.record, i);
    text += text::seconds_text(aid.record.time[i]);
    for (const AidColumn& column : columns) {
      const double number = column.in(row) / column.factor;
      text += column.factor == 1 ? fmt::format(",{:.10g}", number) : fmt::format(",{:.10f}", number);
    }
    text += '\n';
  }
  return text;
}

namespace {
constexpr std::array<std::string_view, 6> measured_columns{"latitude_deg", "vn", "speed_mps", "height_m", "heading_deg", "qw"};  // one of each kind
}

std::optional<AidKind> kind_of_aid(const std::filesystem::path& file) {
  const MappedFile mapped(file);
  const std::string_view head = mapped.text().substr(0, 4096);
  if (!recording_io::solution_kind(head).empty()) return AidKind::gnss;
  if (is_trajectory(head)) return AidKind::pose;
  const auto is_named = [&](std::string_view name) { return head.find(name) != std::string_view::npos; };
  if (!may_be_csv(head) || std::none_of(measured_columns.begin(), measured_columns.end(), is_named)) return std::nullopt;
  std::vector<std::string> names;
  try {
    names = names_of_columns(file);
  } catch (const Error&) {
    return std::nullopt;  // what is wrong with it is said where it is read
  }
  const auto is_of_imu = [](const std::string& name) {
    const inspection::NameHint hint = inspection::hint_of(name);
    return hint.role == inspection::Role::gyro || hint.role == inspection::Role::accel;
  };
  if (std::any_of(names.begin(), names.end(), is_of_imu) || time_column_in(names) == time_columns.end()) return std::nullopt;
  for (const AidKind kind : {AidKind::gnss, AidKind::wheels, AidKind::barometer, AidKind::heading, AidKind::pose, AidKind::attitude})
    for (const AidColumns& group : aid_columns(kind))
      if (!group.front().is_sigma && std::all_of(group.begin(), group.end(), [&](const AidColumn& c) { return is_among(c.name, names); }))
        return kind;
  return std::nullopt;
}

AidFormat aid_csv_format() { return {"CSV", may_be_csv, read_aid_csv}; }

}  // namespace imulab::aid_io
