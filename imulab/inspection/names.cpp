#include "imulab/inspection/names.hpp"

#include "imulab/core/text.hpp"
#include "imulab/recording/unit_names.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <optional>
#include <utility>
#include <vector>

namespace imulab::inspection {

namespace {

char lower(char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); }

/// "accelX_raw.1" -> accel, x, raw, 1
std::vector<std::string> words_of(std::string_view name) {
  std::vector<std::string> words;
  const auto kind = [](char c) { return std::isdigit(static_cast<unsigned char>(c)) ? 1 : std::isalpha(static_cast<unsigned char>(c)) ? 2 : 0; };
  for (std::size_t i = 0; i < name.size(); ++i) {
    const char c = name[i], before = i > 0 ? name[i - 1] : ' ';
    if (kind(c) == 0) continue;
    const bool behind_axis = !words.empty() && words.back().size() == 1 && before >= 'X' && before <= 'Z';  // "AccelXMps2"
    const bool camel = std::isupper(static_cast<unsigned char>(c)) && (std::islower(static_cast<unsigned char>(before)) || behind_axis);
    if (words.empty() || kind(before) != kind(c) || camel) words.emplace_back();
    words.back() += lower(c);
  }
  return words;
}

template <std::size_t N>
bool is_among(const std::string& word, const std::array<std::string_view, N>& list) {
  return std::find(list.begin(), list.end(), word) != list.end();
}

constexpr std::array<std::string_view, 5> accel_words{"a", "acc", "accl", "f", "force"};
constexpr std::array<std::string_view, 9> gyro_words{"g", "w", "omega", "angular", "angvel", "rate", "rates", "rot", "angrate"};
constexpr std::array<std::string_view, 22> other_words{
    "m",   "mag",     "magnetometer", "magnetic", "compass", "q",        "quat",     "quaternion", "orientation", "roll",  "pitch",
    "yaw", "heading", "gps",          "lat",      "lon",     "altitude", "pressure", "baro",       "covariance",  "euler", "velocity"};
/// True if a name is that of a value about a sensor, and not of its readings: "gyro_bias.1", "accel_error_count", "gyro_integral_dt",
/// "accelerometer_timestamp_relative".
constexpr std::array<std::string_view, 19> derived_words{
    "bias",   "biases",  "calibration", "clip", "clipping",      "covariance", "device", "dt",       "err",      "error",
    "health", "healthy", "hz",          "id",   "inconsistency", "relative",   "var",    "variance", "vibration"};
constexpr std::array<std::string_view, 6> temperature_words{"temp", "temperature", "thermometer", "tmp", "temperatures", "degc"};
constexpr std::array<std::string_view, 14> time_words{"t",      "time",   "timestamp", "stamp", "ts",    "clock", "epoch",
                                                      "millis", "micros", "utc",       "tow",   "temps", "zeit",  "tiempo"};
constexpr std::array<std::string_view, 4> tick_words{"tick", "ticks", "cycles", "cnt"};
constexpr std::array<std::string_view, 4> second_words{"s", "sec", "secs", "seconds"};
constexpr std::array<std::string_view, 3> nanosecond_words{"nsec", "nsecs", "nanosec"};
constexpr std::array<std::string_view, 10> number_words{"n", "i", "idx", "index", "sample", "samples", "seq", "counter", "count", "packet"};

bool names_accel(const std::string& word) { return word.starts_with("acce") || is_among(word, accel_words); }
bool names_gyro(const std::string& word) { return word.starts_with("gyr") || is_among(word, gyro_words); }

/// The word before the axis in "gx", "accx"; the word itself where it is none of a sensor with an axis.
std::string without_axis(const std::string& word) {
  if (word.size() < 2 || word.back() < 'x' || word.back() > 'z') return word;
  const std::string stem = word.substr(0, word.size() - 1);
  return names_accel(stem) || names_gyro(stem) || is_among(stem, other_words) ? stem : word;
}

int axis_of(const std::string& word) {
  const bool axis = word == "x" || word == "y" || word == "z" || without_axis(word) != word;
  return axis ? word.back() - 'x' : -1;
}

/// A name is NAME [GROUP]... with groups in either kind of brackets, inside one another, too, and several parts of a group between commas. A bracket
/// inside a unit, as in "m/(s^2)", is none.
struct NameParts {
  std::string stem;
  std::vector<std::string> groups;
};

void add_part(std::string& part, std::vector<std::string>& parts) {
  if (const std::string_view text = trimmed(part); !text.empty()) parts.emplace_back(text);
  part.clear();
}

NameParts parts_of_name(std::string_view name) {
  NameParts parts;
  std::string group;
  std::vector<bool> open;  // of each bracket: whether it begins a group
  std::size_t depth = 0;
  char before = ' ';
  for (const char c : name) {
    const bool opens = c == '[' || c == '(', closes = (c == ']' || c == ')') && !open.empty();
    const bool of_group = opens ? before != '/' && before != '*' && before != '^' : closes && open.back();
    if (opens) open.push_back(of_group);
    if (closes) open.pop_back();
    if (of_group || (depth > 0 && (c == ',' || c == ';'))) {
      add_part(group, parts.groups);
      if (of_group && depth == 0) parts.stem += ' ';
      if (of_group && opens) ++depth;
      if (of_group && closes) --depth;
    } else {
      (depth > 0 ? group : parts.stem) += c;
    }
    if (c != ' ') before = c;
  }
  add_part(group, parts.groups);
  return parts;
}

Role role_of(std::vector<std::string> words) {
  for (std::string& word : words) word = without_axis(word);  // "gx" is g and x, "accx" acc and x
  const auto any = [&](const auto& list) { return std::any_of(words.begin(), words.end(), [&](const std::string& w) { return is_among(w, list); }); };
  const bool angular = std::find(words.begin(), words.end(), "angular") != words.end();
  if (any(tick_words)) return Role::time;
  if (any(temperature_words)) return Role::temperature;
  if (any(nanosecond_words)) return Role::fraction;
  const bool timed = any(time_words) || (words.size() <= 2 && !words.empty() && is_among(words.front(), second_words));
  for (const auto& word : words)  // whole words of a sensor before single letters
    if (word.size() > 1 && (names_accel(word) || names_gyro(word)))
      return any(derived_words) ? Role::other : names_accel(word) ? Role::accel : Role::gyro;
  if (timed) return Role::time;
  if (any(other_words) && !angular) return Role::other;
  if (any(accel_words)) return Role::accel;
  if (any(gyro_words)) return Role::gyro;
  if (any(number_words)) return Role::sample_number;
  return Role::unknown;
}

/// The unit behind the last blank or underline, or that the whole name is: "time_us", "ax_g", "micros".
std::string unit_behind(std::string_view name) {
  name = trimmed(name);
  for (std::size_t cut = name.find_first_of(" _"); cut != std::string_view::npos; cut = name.find_first_of(" _", cut + 1)) {  // "rate_x_deg_per_s"
    const std::string unit = unit_of(name.substr(cut + 1));
    const bool of_gyro = unit == "g" && role_of(words_of(name.substr(0, cut))) != Role::accel;      // the gyro's x in "x_g"
    if (!unit.empty() && unit != "m/s" && unit != "rad" && unit != "deg" && !of_gyro) return unit;  // gyro_rad is in rad/s
  }
  if (const std::string whole = unit_of(name); whole == "ms" || whole == "us" || whole == "ns") return name.size() > 2 ? whole : "";  // "micros"
  if (name.ends_with("US") && name.size() > 2) return "us";                                                                           // TimeUS
  return {};
}

}  // namespace

namespace {

/// Of the symbols that a session names; nothing for another key, all of small letters without blanks.
std::string unit_of_symbol(const std::string& key) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 63> units{{
      {"rad", "rad"},         {"deg", "deg"},     {"ms2", "m/s^2"},     {"rads", "rad/s"},    {"degs", "deg/s"},   {"m/s2", "m/s^2"},
      {"m/s²", "m/s^2"},      {"mps2", "m/s^2"},  {"m/s/s", "m/s^2"},   {"ms-2", "m/s^2"},    {"m/s-2", "m/s^2"},  {"ms⁻²", "m/s^2"},
      {"m·s⁻²", "m/s^2"},     {"g", "g"},         {"gs", "g"},          {"gee", "g"},         {"g0", "g"},         {"mg", "mg"},
      {"ug", "ug"},           {"µg", "ug"},       {"rad/s", "rad/s"},   {"radps", "rad/s"},   {"rads-1", "rad/s"}, {"rads⁻¹", "rad/s"},
      {"rad·s⁻¹", "rad/s"},   {"r/s", "rad/s"},   {"deg/s", "deg/s"},   {"degps", "deg/s"},   {"dps", "deg/s"},    {"°/s", "deg/s"},
      {"degs-1", "deg/s"},    {"mdps", "mdeg/s"}, {"mdeg/s", "mdeg/s"}, {"deg/h", "deg/h"},   {"dph", "deg/h"},    {"°/h", "deg/h"},
      {"deg/min", "deg/min"}, {"dpm", "deg/min"}, {"m/s", "m/s"},       {"arcsec", "arcsec"}, {"s", "s"},          {"ms", "ms"},
      {"millis", "ms"},       {"us", "us"},       {"µs", "us"},         {"micros", "us"},     {"ns", "ns"},        {"nanos", "ns"},
      {"degc", "degC"},       {"°c", "degC"},     {"celsius", "degC"},  {"k", "K"},           {"kelvin", "K"},     {"count", "count"},
      {"counts", "count"},    {"lsb", "count"},   {"lsbs", "count"},    {"raw", "count"},     {"adc", "count"},    {"nanosec", "ns"},
      {"msec", "ms"},         {"usec", "us"},     {"nsec", "ns"},
  }};
  const auto found = std::find_if(units.begin(), units.end(), [&](const auto& unit) { return unit.first == key; });
  return found == units.end() ? std::string() : std::string(found->second);
}

void replace_all(std::string& text, std::string_view from, std::string_view to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size())) text.replace(at, from.size(), to);
}

}  // namespace

std::string unit_of(std::string_view text) {
  std::string key = lowered(text);
  if (key == "g*s") return key;
  std::erase_if(key, [](char c) { return std::string_view(" ^*.\"_()[]").find(c) != std::string_view::npos; });
  if (std::string unit = unit_of_symbol(key); !unit.empty()) return unit;
  constexpr std::array<std::pair<std::string_view, std::string_view>, 21> words{{
      {"milliseconds", "ms"}, {"millisecond", "ms"}, {"microseconds", "us"}, {"microsecond", "us"}, {"nanoseconds", "ns"}, {"nanosecond", "ns"},
      {"seconds", "s"},       {"second", "s"},       {"secs", "s"},          {"sec", "s"},          {"degrees", "deg"},    {"degree", "deg"},
      {"radians", "rad"},     {"radian", "rad"},     {"meters", "m"},        {"metres", "m"},       {"meter", "m"},        {"hours", "h"},
      {"hour", "h"},          {"squared", "2"},      {"per", "/"},
  }};
  for (const auto& [word, symbol] : words) replace_all(key, word, symbol);
  if (key.ends_with("/hr")) key.pop_back();
  return unit_of_symbol(key);
}

NameHint hint_of(std::string_view name) {
  NameHint hint;
  const NameParts parts = parts_of_name(name);
  std::vector<std::string> words = words_of(parts.stem), apart;  // those of the name, and of groups that are neither axis nor unit
  std::optional<int> index;
  for (const std::string& group : parts.groups) {
    const std::string unit = unit_of(group), only = lowered(group);
    if (only.size() == 1 && (std::isdigit(static_cast<unsigned char>(only[0])) || axis_of(only) >= 0)) {
      index = axis_of(only) >= 0 ? axis_of(only) : only[0] - '0';  // "Gyroscope (z)", "gyro_rad[2]"
    } else if (!unit.empty()) {
      if (hint.unit.empty()) hint.unit = unit;
    } else {
      if (hint.unknown.empty()) hint.unknown = group;
      for (std::string& word : words_of(group))
        if (word.size() > 1) apart.push_back(std::move(word));
    }
  }
  if (hint.unit.empty() && hint.unknown.empty()) hint.unit = unit_behind(parts.stem);
  if (!hint.unit.empty()) hint.unknown.clear();
  hint.role = role_of(words);
  if (const Role apart_role = role_of(apart); hint.role == Role::unknown && (apart_role == Role::accel || apart_role == Role::gyro)) {
    hint.role = apart_role;  // "x (gyroscope)"
    hint.unknown.clear();
  }
  for (auto word = words.rbegin(); word != words.rend() && hint.axis < 0; ++word) hint.axis = axis_of(*word);
  const bool numbered = hint.axis < 0 && !index && !words.empty() && words.back().size() == 1 && words.back()[0] >= '1' && words.back()[0] <= '3';
  if (numbered) hint.axis = words.back()[0] - '1';  // gyro.1, gyro.2, gyro.3
  if (index) hint.axis = *index;
  if (hint.axis > 2) hint.axis = -1;
  const bool of_time = hint.unit == "s" || hint.unit == "ms" || hint.unit == "us" || hint.unit == "ns";
  if (of_time && hint.role != Role::fraction) hint.role = Role::time;  // "Temps (s)" is no temperature
  hint.ticks = std::any_of(words.begin(), words.end(), [](const std::string& w) { return is_among(w, tick_words); });
  if (numbered) words.pop_back();
  words.insert(words.end(), apart.begin(), apart.end());
  for (const std::string& word : words)
    if (word.size() > 1 || axis_of(word) < 0) hint.sensor += (hint.sensor.empty() ? "" : " ") + (hint.axis >= 0 ? without_axis(word) : word);
  if (hint.role == Role::fraction && hint.unit.empty()) hint.unit = "ns";
  return hint;
}

namespace {

/// The sensor that has this unit; g is that of an accelerometer where it stands for a whole unit.
Role role_of_unit(const std::string& unit) {
  for (const auto& [quantity, role] : {std::pair{Quantity::accel, Role::accel}, {Quantity::gyro, Role::gyro}}) {
    const std::vector<std::string_view> names = unit_names(quantity, false);
    if (unit != "count" && std::find(names.begin(), names.end(), unit) != names.end()) return role;
  }
  return Role::unknown;
}

/// True if a table has at least the columns of two triads: then its file's name says nothing about one of them.
bool has_two_triads(const SignalTable& table, std::size_t part) {
  constexpr std::size_t of_two = 6, looked_at = 20'000;
  std::size_t readings = 0;
  for (const Signal& signal : table.signals) {
    if (signal.table != part || signal.values.empty()) continue;
    const Role role = hint_of(signal.name).role;
    const auto end = signal.values.begin() + static_cast<std::ptrdiff_t>(std::min(signal.values.size(), looked_at));
    const bool varies = std::any_of(signal.values.begin(), end, [&](double v) { return v != signal.values.front(); });
    if (varies && (role == Role::unknown || role == Role::gyro || role == Role::accel) && ++readings == of_two) return true;
  }
  return false;
}

}  // namespace

NameHint hint_in(const SignalTable& table, std::size_t column) {
  const Signal& signal = table.signals[column];
  const std::string* const own = std::get_if<std::string>(&signal.column);
  const std::size_t sum = own != nullptr && own->find(sum_sign) != std::string::npos ? signal.name.find(sum_sign) : std::string::npos;
  NameHint hint = hint_of(std::string_view(signal.name).substr(0, sum));
  if (sum != std::string::npos) hint.sensor += sum_sign;
  if (hint.role != Role::unknown || (hint.axis < 0 && !signal.name.empty())) return hint;
  const SignalPart* part = signal.table > 0 ? &table.parts[signal.table - 1] : nullptr;
  const auto sensor_of = [](const std::string& name) {
    const Role role = hint_of(name).role;
    return role == Role::gyro || role == Role::accel ? role : Role::unknown;
  };
  hint.role = role_of_unit(!signal.unit.empty() ? signal.unit : hint.unit);
  if (hint.role == Role::unknown && hint.axis >= 0) hint.role = sensor_of(part != nullptr && !part->topic.empty() ? part->topic : table.topic);
  if (hint.role == Role::unknown && hint.axis >= 0 && !has_two_triads(table, signal.table))
    hint.role = sensor_of(std::filesystem::path(part != nullptr && !part->file.empty() ? part->file : table.file).stem().string());
  return hint;
}

}  // namespace imulab::inspection
