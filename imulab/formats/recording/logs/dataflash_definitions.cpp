#include "imulab/formats/recording/logs/dataflash_definitions.hpp"

#include "imulab/formats/text/take_until.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace imulab::recording_io {
namespace {

/// The characters of a format, as ArduPilot's LogStructure.h lists them.
struct DataflashType {
  char format;
  NumberType type;
  std::size_t bytes;
  double divisor = 1;
  std::size_t count = 1;  // of numbers; 0: a text
};

constexpr DataflashType dataflash_types[] = {
    {'b', {'i', 1}, 1},         {'B', {'u', 1}, 1},      {'h', {'i', 2}, 2},      {'H', {'u', 2}, 2},      {'i', {'i', 4}, 4},
    {'I', {'u', 4}, 4},         {'q', {'i', 8}, 8},      {'Q', {'u', 8}, 8},      {'g', {'f', 2}, 2},      {'f', {'f', 4}, 4},
    {'d', {'f', 8}, 8},         {'c', {'i', 2}, 2, 100}, {'C', {'u', 2}, 2, 100}, {'e', {'i', 4}, 4, 100}, {'E', {'u', 4}, 4, 100},
    {'L', {'i', 4}, 4, 1e7},    {'M', {'u', 1}, 1},      {'n', {}, 4, 1, 0},      {'N', {}, 16, 1, 0},     {'Z', {}, 64, 1, 0},
    {'a', {'i', 2}, 64, 1, 32},
};

const DataflashType* dataflash_type(char format) {
  const auto found =
      std::find_if(std::begin(dataflash_types), std::end(dataflash_types), [format](const DataflashType& t) { return t.format == format; });
  return found == std::end(dataflash_types) ? nullptr : found;
}

std::string_view until_zero(std::string_view text) { return text.substr(0, text.find('\0')); }

/// A field of a message by its name; nothing where the message has no such field.
std::string_view field_bytes(const DataflashMessage& layout, std::string_view message, std::string_view name) {
  for (const DataflashField& field : layout.fields)
    if (field.name == name) return message.substr(field.offset, dataflash_type(field.format)->bytes);
  return {};
}

/// A unit as sessions name it; empty where they have none.
std::string session_unit(std::string_view unit) {
  if (unit == "m/s/s") return "m/s^2";
  for (const char* same : {"rad/s", "deg/s", "rad", "deg", "m/s", "degC", "K", "s"})
    if (unit == same) return same;
  return "";
}

/// The unit of a field that the log itself gives none, as those before 2018 (no FMTU): ArduPilot's list of log messages has it for the sensors' own.
std::string documented_unit(std::string_view message, std::string_view field) {
  const std::string_view name = message.substr(0, message.find_last_not_of("123") + 1);  // IMU2, ACC1
  if (name != "IMU" && name != "ACC" && name != "GYR") return "";
  if (field == "GyrX" || field == "GyrY" || field == "GyrZ") return "rad/s";
  if (field == "AccX" || field == "AccY" || field == "AccZ") return "m/s^2";
  return field == "Temp" || field == "T" ? "degC" : "";
}

}  // namespace

void DataflashDefinitions::define(std::string_view message) {
  const auto id = static_cast<unsigned char>(message[3]);
  DataflashMessage defined;
  defined.length = static_cast<unsigned char>(message[4]);
  defined.name = until_zero(message.substr(5, 4));
  const std::string_view formats = until_zero(message.substr(9, 16));
  std::string_view labels = until_zero(message.substr(25, 64));
  std::size_t offset = 3;
  for (const char format : formats) {
    const DataflashType* type = dataflash_type(format);
    if (type == nullptr || offset + type->bytes > defined.length) break;
    defined.fields.push_back({std::string(text::take_until(labels, ',')), format, offset});
    offset += type->bytes;
  }
  const DataflashMessage& before = messages_[id];
  if (before.name == defined.name) {
    defined.units = before.units;
    defined.multipliers = before.multipliers;
    if (defined.fields.size() == before.fields.size()) defined.instance = before.instance;
  }
  messages_[id] = std::move(defined);
  const DataflashMessage& now = messages_[id];
  const bool defines_others = id == dataflash_fmt || now.name == "FMTU" || now.name == "UNIT" || now.name == "MULT";
  const std::size_t length = id == dataflash_fmt ? std::max(dataflash_fmt_length, now.length) : now.length;
  brief_[id] = {static_cast<std::uint16_t>(length), static_cast<std::uint16_t>(now.instance), defines_others};
}

std::optional<unsigned char> DataflashDefinitions::add(std::string_view message) {
  const auto id = static_cast<unsigned char>(message[2]);
  if (id == dataflash_fmt) {
    if (message.size() >= dataflash_fmt_length) define(message);
    return std::nullopt;
  }
  const DataflashMessage& layout = messages_[id];
  const std::string_view unit_id = field_bytes(layout, message, "Id");
  if (layout.name == "UNIT") {
    const std::string_view label = field_bytes(layout, message, "Label");
    if (!unit_id.empty()) units_[unit_id[0]] = until_zero(label);
  } else if (layout.name == "MULT") {
    const std::string_view factor = field_bytes(layout, message, "Mult");
    if (!unit_id.empty() && factor.size() == sizeof(double)) multipliers_[unit_id[0]] = load<double>(factor.data());
  } else if (layout.name == "FMTU") {
    const std::string_view of = field_bytes(layout, message, "FmtType");
    if (of.empty()) return std::nullopt;
    const std::string units(until_zero(field_bytes(layout, message, "UnitIds"))), multipliers(until_zero(field_bytes(layout, message, "MultIds")));
    DataflashMessage& defined = messages_[static_cast<unsigned char>(of[0])];
    defined.units = units;
    defined.multipliers = multipliers;
    const std::size_t number = defined.units.find('#');
    const std::size_t instance = number < defined.fields.size() && defined.fields[number].format == 'B' ? defined.fields[number].offset : no_instance;
    const bool changes = instance != defined.instance;
    defined.instance = instance;
    brief_[static_cast<unsigned char>(of[0])].instance = static_cast<std::uint16_t>(instance);
    if (changes) return static_cast<unsigned char>(of[0]);
  }
  return std::nullopt;
}

std::vector<DataflashColumn> DataflashDefinitions::columns(unsigned char id) const {
  const DataflashMessage& message = messages_[id];
  std::vector<DataflashColumn> columns;
  for (std::size_t i = 0; i < message.fields.size(); ++i) {
    const DataflashField& field = message.fields[i];
    const DataflashType& type = *dataflash_type(field.format);
    const auto unit = i < message.units.size() ? units_.find(message.units[i]) : units_.end();
    const auto multiplier = i < message.multipliers.size() ? multipliers_.find(message.multipliers[i]) : multipliers_.end();
    double divisor = type.divisor;
    // The multiplier of a format that has its own divisor says the same once more; 0 stands for none.
    if (divisor == 1 && multiplier != multipliers_.end() && multiplier->second > 0) divisor = 1 / multiplier->second;
    if (std::abs(divisor - std::round(divisor)) < 1e-6 * divisor) divisor = std::round(divisor);  // multipliers may be stored as float
    std::string name = unit != units_.end() ? session_unit(unit->second) : "";
    if (name == "s" && type.type.kind != 'f')
      for (const auto& [finer, per_second] : {std::pair("ms", 1e3), std::pair("us", 1e6), std::pair("ns", 1e9)})
        if (divisor == per_second) name = finer, divisor = 1;
    if (name.empty() && field.name.ends_with("US")) name = "us";  // of logs before FMTU
    if (name.empty() && field.name.ends_with("TimeMS")) name = "ms";
    if (name.empty() && unit == units_.end() && divisor == 1) name = documented_unit(message.name, field.name);
    for (std::size_t k = 0; k < type.count; ++k)
      columns.push_back(
          {{type.count == 1 ? field.name : fmt::format("{}.{}", field.name, k + 1), name}, {type.type, field.offset + k * type.type.bytes}, divisor});
  }
  return columns;
}

}  // namespace imulab::recording_io
