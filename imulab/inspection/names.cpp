#include "imulab/inspection/names.hpp"

#include "imulab/core/text.hpp"
#include "imulab/recording/unit_names.hpp"
#include "imulab/units.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
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
    const bool camel = std::isupper(static_cast<unsigned char>(c)) && std::islower(static_cast<unsigned char>(before));
    if (words.empty() || kind(before) != kind(c) || camel) words.emplace_back();
    words.back() += lower(c);
  }
  return words;
}

template <std::size_t N>
bool is_among(const std::string& word, const std::array<std::string_view, N>& list) {
  return std::find(list.begin(), list.end(), word) != list.end();
}

constexpr std::array<std::string_view, 9> accel_words{"a", "acc", "accel", "acceleration", "accelerometer", "accelerations", "accels", "f", "force"};
constexpr std::array<std::string_view, 13> gyro_words{"g",       "gyr",    "gyro", "gyros", "gyroscope", "w",      "omega",
                                                      "angular", "angvel", "rate", "rates", "rot",       "angrate"};
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

/// The text in brackets.
std::string_view in_brackets(std::string_view name) {
  for (const auto& [open, close] : {std::pair{'[', ']'}, {'(', ')'}}) {
    const std::size_t begin = name.find(open), end = name.find(close, begin == std::string_view::npos ? 0 : begin);
    if (begin != std::string_view::npos && end != std::string_view::npos) return name.substr(begin + 1, end - begin - 1);
  }
  return {};
}

/// The index of "gyro_rad[2]", from 0.
std::optional<int> index_in_brackets(std::string_view name) {
  const std::string_view inside = in_brackets(name);
  if (inside.size() != 1 || !std::isdigit(static_cast<unsigned char>(inside.front()))) return std::nullopt;
  return inside.front() - '0';
}

/// The unit in brackets, or behind the last blank or underline: "acc_x [m/s^2]", "time_us".
std::string unit_in(std::string_view name) {
  if (index_in_brackets(name)) return unit_in(name.substr(0, name.find_first_of("[(")));
  if (const std::string_view inside = in_brackets(name); !inside.empty()) return unit_of(inside);
  for (std::size_t cut = name.find_first_of(" _"); cut != std::string_view::npos; cut = name.find_first_of(" _", cut + 1))  // "rate_x_deg_per_s"
    if (std::string unit = unit_of(name.substr(cut + 1));
        !unit.empty() && unit != "m/s" && unit != "rad" && unit != "deg" && !name.ends_with("_g") && !name.ends_with(" g"))
      return unit;  // ..._g may be a gyro's, gyro_rad is in rad/s
  if (const std::string whole = unit_of(name); whole == "ms" || whole == "us" || whole == "ns") return name.size() > 2 ? whole : "";  // "micros"
  if (name.ends_with("US") && name.size() > 2) return "us";                                                                           // TimeUS
  return {};
}

int axis_of(const std::vector<std::string>& words) {
  for (auto word = words.rbegin(); word != words.rend(); ++word) {
    if (*word == "x" || *word == "y" || *word == "z") return (*word)[0] - 'x';
    const bool letter = word->size() > 1 && (word->back() == 'x' || word->back() == 'y' || word->back() == 'z');
    if (letter) {
      const std::string stem = word->substr(0, word->size() - 1);
      if (is_among(stem, accel_words) || is_among(stem, gyro_words) || is_among(stem, other_words)) return word->back() - 'x';
    }
  }
  return -1;
}

Role role_of(std::vector<std::string> words) {
  for (std::string& word : words)  // "gx" is g and x, "accx" acc and x
    if (word.size() > 1 && (word.back() == 'x' || word.back() == 'y' || word.back() == 'z')) {
      const std::string stem = word.substr(0, word.size() - 1);
      if (is_among(stem, accel_words) || is_among(stem, gyro_words) || is_among(stem, other_words)) word = stem;
    }
  const auto any = [&](const auto& list) { return std::any_of(words.begin(), words.end(), [&](const std::string& w) { return is_among(w, list); }); };
  const bool angular = std::find(words.begin(), words.end(), "angular") != words.end();
  if (any(tick_words)) return Role::time;
  if (any(temperature_words)) return Role::temperature;
  if (any(nanosecond_words)) return Role::fraction;
  const bool timed = any(time_words) || (words.size() <= 2 && !words.empty() && is_among(words.front(), second_words));
  for (const auto& word : words)  // whole words of a sensor before single letters
    if (word.size() > 1 && (is_among(word, accel_words) || is_among(word, gyro_words)))
      return any(derived_words) ? Role::other : is_among(word, accel_words) ? Role::accel : Role::gyro;
  if (timed) return Role::time;
  if (any(other_words) && !angular) return Role::other;
  if (any(accel_words)) return Role::accel;
  if (any(gyro_words)) return Role::gyro;
  if (any(number_words)) return Role::sample_number;
  return Role::unknown;
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
  std::erase_if(key, [](char c) { return c == ' ' || c == '^' || c == '*' || c == '.' || c == '\"' || c == '_'; });
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
  hint.unit = unit_in(name);
  const std::string_view stem = name.substr(0, std::min(name.find('['), name.find('(')));
  const std::vector<std::string> words = words_of(stem);
  hint.role = role_of(words);
  hint.axis = axis_of(words);
  if (hint.axis < 0 && !words.empty() && words.back().size() == 1 && std::isdigit(static_cast<unsigned char>(words.back()[0])))
    hint.axis = words.back()[0] - '1';  // gyro.1, gyro.2, gyro.3
  const std::optional<int> index = index_in_brackets(name);
  if (index) hint.axis = *index;
  if (hint.axis > 2) hint.axis = -1;
  if (const std::string_view inside = in_brackets(name); hint.unit.empty() && !index) hint.unknown = std::string(inside);
  const bool of_time = hint.unit == "s" || hint.unit == "ms" || hint.unit == "us" || hint.unit == "ns";
  if (of_time && hint.role != Role::fraction) hint.role = Role::time;  // "Temps (s)" is no temperature
  hint.ticks = std::any_of(words.begin(), words.end(), [](const std::string& w) { return is_among(w, tick_words); });
  for (const std::string& word : words) {
    const bool is_axis = word == "x" || word == "y" || word == "z" || (&word == &words.back() && word.size() == 1);
    if (!is_axis) hint.sensor += (hint.sensor.empty() ? "" : " ") + (hint.axis >= 0 && axis_of({word}) >= 0 ? word.substr(0, word.size() - 1) : word);
  }
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

}  // namespace

NameHint hint_in(const SignalTable& table, std::size_t column) {
  const Signal& signal = table.signals[column];
  NameHint hint = hint_of(signal.name);
  if (hint.role != Role::unknown || (hint.axis < 0 && !signal.name.empty())) return hint;
  const SignalPart* part = signal.table > 0 ? &table.parts[signal.table - 1] : nullptr;
  const auto sensor_of = [](const std::string& name) {
    const Role role = hint_of(name).role;
    return role == Role::gyro || role == Role::accel ? role : Role::unknown;
  };
  hint.role = role_of_unit(!signal.unit.empty() ? signal.unit : hint.unit);
  if (hint.role == Role::unknown && hint.axis >= 0) hint.role = sensor_of(part != nullptr && !part->topic.empty() ? part->topic : table.topic);
  if (hint.role == Role::unknown && hint.axis >= 0)
    hint.role = sensor_of(std::filesystem::path(part != nullptr && !part->file.empty() ? part->file : table.file).stem().string());
  return hint;
}

namespace {

struct Possible {
  std::string unit;
  Output output;
  double size;  ///< what one SI unit (of rate) reads: m/s^2 or rad/s
};

std::vector<Possible> possible_units(Quantity quantity, double interval_s) {
  std::vector<Possible> all;
  for (const Output output : {Output::rate, Output::increment})
    for (const std::string_view unit : unit_names(quantity, output == Output::increment))
      if (unit != "count") all.push_back({std::string(unit), output, (output == Output::increment ? interval_s : 1.0) / si_factor(unit)});
  return all;
}

std::string with_output(const Possible& p) { return p.output == Output::rate ? p.unit : p.unit + " a sample"; }

/// One of the units that fit: the named one, or the only one.
UnitGuess choose(const std::vector<Possible>& fit, const std::vector<Possible>& all, const std::string& named, const std::string& what,
                 const std::string& key, bool whole) {
  UnitGuess guess;
  guess.evidence = what;
  const auto is_named = [&](const Possible& p) { return p.unit == named; };
  const auto take = [&](const Possible& p) {
    guess.unit = p.unit;
    guess.output = p.output;
    guess.evidence = what + ": " + with_output(p);
  };
  if (const auto found = std::find_if(fit.begin(), fit.end(), is_named); !named.empty() && found != fit.end()) {
    take(*found);
    return guess;
  }
  if (!named.empty() && std::any_of(all.begin(), all.end(), is_named)) {
    std::string instead;
    for (const Possible& p : fit) instead += (instead.empty() ? "" : " or ") + with_output(p);
    guess.unit = named;
    guess.open = fmt::format("{}.unit: the file says {}, but {}", key, named, what + (instead.empty() ? "" : ", as in " + instead));
    return guess;
  }
  if (!named.empty() && named != "count") {
    guess.open = fmt::format("{}.unit: the file says {}, which is no unit known here; {}", key, named, what);
    return guess;
  }
  if (named == "count") {
    guess.evidence = what + ": counts, as the file says";
    return guess;
  }
  if (fit.size() == 1) {
    take(fit.front());
    return guess;
  }
  if (fit.empty() && whole) {
    guess.evidence = what + ", whole numbers: counts";
    return guess;
  }
  std::string list;
  for (const Possible& p : fit) list += (list.empty() ? "" : " or ") + with_output(p);
  guess.open = fmt::format("{}.unit: {}, {}", key, what, fit.empty() ? "which is no unit known here" : "which could be " + list);
  return guess;
}

}  // namespace

UnitGuess accel_unit(double norm, double least, double most, double interval_s, const std::string& named, bool whole) {
  const std::vector<Possible> all = possible_units(Quantity::accel, interval_s);
  std::vector<Possible> fit;
  constexpr double tolerance = 0.1;  // offsets and scales of a sensor before its calibration
  for (const Possible& p : all)
    if (std::abs(norm / (unit::g * p.size) - 1) < tolerance) fit.push_back(p);
  // Whole numbers near a thousand, or a million, to g are a unit; near a power of two they may be counts.
  const double octave = std::exp2(std::round(std::log2(norm)));
  std::string what = least < most ? fmt::format("|a| at rest {:.5g} to {:.5g}", least, most) : fmt::format("|a| at rest {:.5g}", norm);
  if (whole && !fit.empty() && named.empty() && std::abs(norm / octave - 1) < 0.05) {
    fit.push_back({"count", Output::rate, octave / unit::g});
  } else if (whole && fit.empty()) {
    what += fmt::format(" ({:.5g} to g)", norm);
  }
  return choose(fit, all, named, what, "accel", whole);
}

UnitGuess gyro_unit(double scale, double interval_s, const std::string& named, bool whole) {
  const std::vector<Possible> all = possible_units(Quantity::gyro, interval_s);
  std::vector<Possible> fit;
  constexpr double tolerance = 0.15;  // of a coarse solution, on an uncalibrated sensor
  for (const Possible& p : all)
    if (std::abs(scale * p.size - 1) < tolerance) fit.push_back(p);
  const double per_degree = unit::deg / scale;
  const std::string what = fmt::format("1 deg/s reads {:.4g}, by the turns between rests", per_degree);
  if (whole && fit.size() == 1 && named.empty() && fit.front().unit != "mdeg/s") fit.push_back({"count", Output::rate, 1 / scale});
  return choose(fit, all, named, what, "gyro", whole);
}

std::vector<double> gyro_scales(double interval_s) {
  std::vector<double> scales;
  for (const Possible& p : possible_units(Quantity::gyro, interval_s)) scales.push_back(1 / p.size);
  return scales;
}

}  // namespace imulab::inspection
