#include "imulab/formats/recording/logs/ulog_definitions.hpp"

#include "imulab/error.hpp"
#include "imulab/formats/text/take_until.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <utility>

namespace imulab::recording_io {
namespace {

struct UlogType {
  std::string_view name;
  NumberType type;
  bool is_text = false;
};

constexpr UlogType ulog_types[] = {
    {"int8_t", {'i', 1}},  {"uint8_t", {'u', 1}},  {"int16_t", {'i', 2}}, {"uint16_t", {'u', 2}}, {"int32_t", {'i', 4}}, {"uint32_t", {'u', 4}},
    {"int64_t", {'i', 8}}, {"uint64_t", {'u', 8}}, {"float", {'f', 4}},   {"double", {'f', 8}},   {"bool", {'u', 1}},    {"char", {'u', 1}, true},
};

/// The file names no units. Those of PX4's inertial messages (msg/SensorAccel.msg and so on) and of all time stamps.
struct UlogUnit {
  std::string_view message, field, unit;
};

constexpr UlogUnit ulog_units[] = {
    {"", "timestamp", "us"},
    {"", "timestamp_sample", "us"},
    {"sensor_accel", "x", "m/s^2"},
    {"sensor_accel", "y", "m/s^2"},
    {"sensor_accel", "z", "m/s^2"},
    {"sensor_accel", "temperature", "degC"},
    {"sensor_gyro", "x", "rad/s"},
    {"sensor_gyro", "y", "rad/s"},
    {"sensor_gyro", "z", "rad/s"},
    {"sensor_gyro", "temperature", "degC"},
    {"sensor_combined", "gyro_rad", "rad/s"},
    {"sensor_combined", "accelerometer_m_s2", "m/s^2"},
    {"vehicle_imu", "delta_angle", "rad"},
    {"vehicle_imu", "delta_velocity", "m/s"},
};

std::string ulog_unit(std::string_view message, std::string_view column) {
  const auto found = std::find_if(std::begin(ulog_units), std::end(ulog_units), [&](const UlogUnit& u) {
    return (u.message.empty() || u.message == message) && column.starts_with(u.field) &&
           (column.size() == u.field.size() || column[u.field.size()] == '.');
  });
  return found == std::end(ulog_units) ? "" : std::string(found->unit);
}

constexpr std::size_t longest_message = 65535;

}  // namespace

void UlogDefinitions::add(std::string_view definition) {
  const std::size_t colon = definition.find(':');
  if (colon == std::string_view::npos) return;
  std::vector<Field> fields;
  for (std::string_view rest = definition.substr(colon + 1); !rest.empty();) {
    const std::string_view field = text::take_until(rest, ';');
    const std::size_t blank = field.find(' ');
    if (blank == std::string_view::npos) continue;
    std::string_view type = field.substr(0, blank);
    std::size_t count = 0;
    if (const std::size_t bracket = type.find('['); bracket != std::string_view::npos) {
      std::from_chars(type.data() + bracket + 1, type.data() + type.size(), count);
      type = type.substr(0, bracket);
      if (count == 0 || count > longest_message) continue;
    }
    fields.push_back({std::string(type), std::string(field.substr(blank + 1)), count});
  }
  fields_.insert_or_assign(std::string(definition.substr(0, colon)), std::move(fields));
}

std::vector<UlogColumn> UlogDefinitions::columns(const std::string& message, const std::string& file) const {
  std::vector<UlogColumn> result;
  std::size_t offset = 0;
  append(result, offset, message, "", 0, file);
  for (UlogColumn& column : result) column.description.unit = ulog_unit(message, column.description.name);
  return result;
}

void UlogDefinitions::append(std::vector<UlogColumn>& columns, std::size_t& offset, const std::string& message, const std::string& before, int depth,
                             const std::string& file) const {
  const auto definition = fields_.find(message);
  if (definition == fields_.end()) throw Error(fmt::format("{}: message {} is not defined; expected its definition at the beginning", file, message));
  if (depth > 16) throw Error(fmt::format("{}: message {} is nested too deep; expected no message that contains itself", file, message));
  for (const Field& field : definition->second) {
    const auto type = std::find_if(std::begin(ulog_types), std::end(ulog_types), [&](const UlogType& t) { return t.name == field.type; });
    for (std::size_t i = 0; i < std::max<std::size_t>(field.count, 1); ++i) {
      const std::string name = before + field.name + (field.count > 0 ? fmt::format(".{}", i + 1) : "");
      if (type == std::end(ulog_types)) {
        const std::size_t begin = offset;
        append(columns, offset, field.type, name + ".", depth + 1, file);
        if (offset == begin) break;  // without a byte, however often
        continue;
      }
      if (!type->is_text && !field.name.starts_with("_padding")) columns.push_back({{name, ""}, {type->type, offset}});
      offset += type->type.bytes;
      if (offset > longest_message) throw Error(fmt::format("{}: message {} is longer than a message can be", file, message));
    }
  }
}

}  // namespace imulab::recording_io
