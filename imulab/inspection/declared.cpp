#include "imulab/inspection/declared.hpp"

#include "imulab/core/nearest_name.hpp"
#include "imulab/error.hpp"
#include "imulab/grade.hpp"
#include "imulab/inspection/time.hpp"
#include "imulab/recording/unit_names.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <string_view>
#include <utility>

namespace imulab {

std::vector<std::string> declaration_keys() {
  return {"rate_hz",    "time.column",  "time.unit", "time.ticks_per_s", "time.wrap_bits", "gyro.columns",
          "gyro.unit",  "gyro.output",  "gyro.axes", "accel.columns",    "accel.unit",     "accel.output",
          "accel.axes", "latitude_deg", "height_m",  "gravity_mps2",     "grade",          "layout"};
}

Site declared_site(const Declarations& declared) {
  Site site;
  const auto number = [&](const char* key, double low, double high, double factor) -> std::optional<double> {
    const auto found = declared.find(key);
    if (found == declared.end()) return std::nullopt;
    double value = 0;
    const std::string& text = found->second;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    const bool number = error == std::errc() && end == text.data() + text.size();
    if (!number || !(value >= low && value <= high))
      throw Error(fmt::format("{} = {}: is {}; expected a number from {} to {}", key, text, number ? "out of range" : "no number", low, high));
    return value * factor;
  };
  site.latitude = number("latitude_deg", -90, 90, unit::deg);
  site.height = number("height_m", -12e3, 100e3, 1);
  site.given_gravity = number("gravity_mps2", 9, 10.5, 1);
  return site;
}

std::optional<std::string> declared_grade(const Declarations& declared) {
  const auto found = declared.find("grade");
  if (found == declared.end()) return std::nullopt;
  return std::string(grade(found->second).name);
}

namespace inspection {
namespace {

const std::string* find(const Declarations& declared, const std::string& key) {
  const auto found = declared.find(key);
  return found == declared.end() ? nullptr : &found->second;
}

std::vector<std::string> parts_of(const std::string& text) {
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == ',' || c == ' ') {
      if (!parts.back().empty()) parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  if (parts.back().empty()) parts.pop_back();
  return parts;
}

std::string file_of(const SignalTable& table, std::size_t i) {
  const Signal& signal = table.signals[i];
  const std::string own = signal.table > 0 ? table.parts[signal.table - 1].file : "";
  return own.empty() ? std::filesystem::path(table.file).filename().string() : own;
}

/// The column of that name, or FILE:COLUMN where several files have it.
std::size_t column_index(const SignalTable& table, const std::string& text, const std::string& key) {
  std::optional<std::size_t> found;
  for (std::size_t i = 0; i < table.signals.size(); ++i) {
    const Signal& signal = table.signals[i];
    const int* number = std::get_if<int>(&signal.column);
    const std::string in_file = number != nullptr ? fmt::format("{}", *number) : signal.name;
    if (!table.parts.empty() && text == file_of(table, i) + ":" + in_file) return i;
    if (signal.name.empty() || signal.name != text) continue;
    if (found && table.signals[*found].table != signal.table)
      throw Error(fmt::format("{} = {}: several files have such a column; expected {}:{} or {}:{}", key, text, file_of(table, *found), text,
                              file_of(table, i), text));
    if (!found) found = i;
  }
  if (found) return *found;
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error == std::errc() && end == text.data() + text.size() && number >= 1 && number <= table.signals.size()) return number - 1;
  std::vector<std::string> names;
  for (const Signal& signal : table.signals) names.push_back(signal.name);
  throw Error(fmt::format("{} = {}: {} has no such column; expected a name in its header or a number from 1 to {}{}", key, text, table.file,
                          table.signals.size(), did_you_mean(text, names)));
}

double positive_number(const std::string& text, const std::string& key) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !(value > 0) || !std::isfinite(value))
    throw Error(fmt::format("{} = {}: is not above 0; expected a number", key, text));
  return value;
}

std::optional<SignalTriad> columns(const SignalTable& table, const Declarations& declared, const std::string& key) {
  const std::string* text = find(declared, key);
  if (text == nullptr) return std::nullopt;
  const std::vector<std::string> parts = parts_of(*text);
  if (parts.size() != 3) throw Error(fmt::format("{} = {}: {} columns; expected three", key, *text, parts.size()));
  return SignalTriad{column_index(table, parts[0], key), column_index(table, parts[1], key), column_index(table, parts[2], key)};
}

}  // namespace

std::string column_name(const SignalTable& table, std::size_t i) {
  const std::string& name = table.signals[i].name;
  if (name.empty()) return fmt::format("column {}", i + 1);
  const auto same = [&](const Signal& other) { return other.name == name && other.table != table.signals[i].table; };
  return std::any_of(table.signals.begin(), table.signals.end(), same) ? file_of(table, i) + ":" + name : name;
}

std::string declared_as(const SignalTable& table, const SignalTriad& triad) {
  std::vector<std::string> words;
  for (const std::size_t i : triad) {
    const std::string name = column_name(table, i);
    const bool plain = !table.signals[i].name.empty() && name.find_first_of(" ,'\"()[]&|;<>*?$\\") == std::string::npos;
    words.push_back(plain ? name : fmt::format("{}", i + 1));
  }
  return fmt::format("{}", fmt::join(words, ","));
}

void check_declarations(const Declarations& declared) {
  const std::vector<std::string> keys = declaration_keys();
  for (const auto& [key, value] : declared)
    if (std::find(keys.begin(), keys.end(), key) == keys.end()) throw Error(fmt::format("{} is not a key{}", key, expected_name(key, keys)));
}

DeclaredColumns declared_columns(const SignalTable& table, const Declarations& declared) {
  const DeclaredColumns result{columns(table, declared, "gyro.columns"), columns(table, declared, "accel.columns")};
  if (result.gyro && result.accel)
    for (const std::size_t i : *result.gyro)
      if (std::find(result.accel->begin(), result.accel->end(), i) != result.accel->end())
        throw Error(fmt::format("gyro.columns, accel.columns: {} is declared as both; expected three other columns", column_name(table, i)));
  return result;
}

namespace {

/// Rows at equal spacing, at the mean rate of their stamps, which single stamps do not have.
double take_rows_evenly(const SignalTable& table, TimeGuess& guess) {
  const std::vector<std::int64_t> stamps = stamps_of(table, guess);
  if (stamps.size() < 2 || stamps.back() <= stamps.front()) return *guess.rate_hz;
  const std::size_t half = stamps.size() / 2;
  double apart_s = 0;  // of the halves' means: single stamps do not matter
  for (std::size_t i = 0; i < half; ++i) apart_s += 1e-9 * static_cast<double>(stamps[i + half] - stamps[i]) / static_cast<double>(half);
  const double rate_hz = static_cast<double>(half) / apart_s;
  guess.replaced = std::exchange(guess.column, std::nullopt);
  guess.source = {};
  guess.source.column.reset();
  guess.source.unit = "sample";
  guess.rate_hz = rate_hz;
  guess.evidence += fmt::format("; its single steps vary, their sums do not: the rows are taken at equal spacing, {:.5g} Hz", rate_hz);
  return rate_hz;
}

}  // namespace

TimeGuess declared_time(const SignalTable& table, const Declarations& declared, TimeGuess guess) {
  if (const std::string* column = find(declared, "time.column"); column != nullptr && *column == "none") {
    guess = {};
    guess.source.column.reset();
    guess.source.unit = "sample";
    guess.evidence = "rows at equal spacing, as declared";
    guess.open = {"rate_hz", "rows without stamps have no other rate; --rate HZ"};
  } else if (column != nullptr) {
    const std::size_t index = column_index(table, *column, "time.column");
    SignalTable alone = table;
    for (std::size_t i = 0; i < alone.signals.size(); ++i)
      if (i != index) alone.signals[i].values.assign(table.rows(), 0);
    guess = recognize_time(alone);
    guess.column = index;
    guess.source.column = table.signals[index].column;
  }
  if (const std::string* unit = find(declared, "time.unit")) {
    std::vector<std::string_view> units = unit_names(Quantity::time, false);
    units.insert(units.end(), {"tick", "sample"});
    if (std::find(units.begin(), units.end(), *unit) == units.end())
      throw Error(fmt::format("time.unit = {}: is no unit of time; expected one of {}", *unit, fmt::join(units, ", ")));
    guess.source.unit = *unit;
    guess.by_rate_alone = false;
    guess.open = {};
    guess.evidence = fmt::format("{}, as declared", *unit);
  }
  if (const std::string* ticks = find(declared, "time.ticks_per_s")) {
    guess.source.unit = "tick";
    guess.source.ticks_per_s = positive_number(*ticks, "time.ticks_per_s");
    guess.by_rate_alone = false;
    guess.open = {};
    guess.evidence = fmt::format("{} ticks to a second, as declared", *ticks);
  }
  if (const std::string* bits = find(declared, "time.wrap_bits")) {
    const double value = positive_number(*bits, "time.wrap_bits");
    if (value < 8 || value > 32 || value != std::floor(value)) throw Error(fmt::format("time.wrap_bits = {}: expected 8 to 32", *bits));
    guess.source.wrap_bits = static_cast<int>(value);
  }
  if (guess.source.unit == "tick" && !guess.source.ticks_per_s) guess.open = length_of_tick();
  std::optional<double> average_hz;
  if (guess.even_on_average && guess.column && guess.open.empty()) average_hz = take_rows_evenly(table, guess);
  if (const std::string* rate = find(declared, "rate_hz")) {
    const double declared_hz = positive_number(*rate, "rate_hz");
    if (declared_hz < 1e-3 || declared_hz > 1e6) throw Error(fmt::format("rate_hz = {}: is out of range; expected 0.001 to 1000000", *rate));
    if (guess.column && guess.source.unit != "sample")
      throw Error(
          fmt::format("rate_hz = {}: the rows have stamps; expected no rate, or rows at equal spacing: --time none (time.column = none)", *rate));
    constexpr double oscillators = 0.02;  // those of a cheap logger agree to less
    if (average_hz && std::abs(declared_hz / *average_hz - 1) > oscillators)
      throw Error(
          fmt::format("rate_hz = {}: the stamps of {} give {:.5g} Hz on average; expected that rate, or time.column = none where they are wrong",
                      *rate, column_name(table, *guess.replaced), *average_hz));
    guess.rate_hz = declared_hz;
    guess.open = {};
    guess.evidence += fmt::format("; {} Hz, as declared", *rate);
  } else if (guess.column && guess.open.empty()) {
    const std::vector<std::int64_t> stamps = guess.source.unit == "sample" ? std::vector<std::int64_t>{} : stamps_of(table, guess);
    if (const ClockQuality clock = clock_quality(stamps); clock.rate_hz > 0) guess.rate_hz = clock.rate_hz;
    if (guess.source.unit == "sample") guess.open = {"rate_hz", "samples are numbered, not timed"};
  }
  return guess;
}

void declare_unit(const Declarations& declared, const std::string& triad, UnitGuess& guess) {
  if (const std::string* output = find(declared, triad + ".output")) {
    if (*output != "rate" && *output != "increment")
      throw Error(fmt::format("{}.output = {}: is not known; expected rate or increment", triad, *output));
    guess.output = *output == "rate" ? Output::rate : Output::increment;
  }
  const std::string* unit = find(declared, triad + ".unit");
  if (unit == nullptr) return;
  const Quantity quantity = triad == "gyro" ? Quantity::gyro : Quantity::accel;
  const std::string_view of_rate = unit_name(*unit, quantity, false), of_increment = unit_name(*unit, quantity, true);
  if (of_rate.empty() && of_increment.empty())
    throw Error(fmt::format("{}.unit = {}: is no unit of these readings; expected one of {} or of {}", triad, *unit,
                            fmt::join(unit_names(quantity, false), ", "), fmt::join(unit_names(quantity, true), ", ")));
  if (!find(declared, triad + ".output")) guess.output = !of_rate.empty() ? Output::rate : Output::increment;
  guess.unit = !of_rate.empty() ? of_rate : of_increment;
  guess.evidence = fmt::format("{}, as declared", *unit);
  guess.open = {};
}

std::optional<std::array<BodyAxis, 3>> declared_axes(const Declarations& declared, const std::string& triad) {
  const std::string* text = find(declared, triad + ".axes");
  if (text == nullptr) return std::nullopt;
  const std::vector<std::string> parts = parts_of(*text);
  std::array<BodyAxis, 3> axes;
  std::array<int, 3> used{};
  bool good = parts.size() == 3;
  for (std::size_t i = 0; good && i < 3; ++i) {
    const std::string& part = parts[i];
    good = part.size() == 2 && (part[0] == '+' || part[0] == '-') && part[1] >= 'x' && part[1] <= 'z';
    if (!good) break;
    axes[i] = {part[1] - 'x', part[0] == '+' ? 1 : -1};
    good = ++used[static_cast<std::size_t>(axes[i].index)] == 1;
  }
  if (!good) throw Error(fmt::format("{}.axes = {}: is not three different body axes; expected as in +x,-y,+z", triad, *text));
  return axes;
}

}  // namespace inspection
}  // namespace imulab
