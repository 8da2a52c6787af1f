#include "imulab/formats/noise/data_sheet.hpp"

#include "imulab/core/nearest_name.hpp"
#include "imulab/core/stated_limit.hpp"
#include "imulab/core/text.hpp"
#include "imulab/core/unit_expression.hpp"
#include "imulab/error.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/toml_fields.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>

namespace imulab {
namespace {

constexpr std::string_view sheet_blanks = " \t\r\n";

/// A quantity: its dimension is that of the readings to a power, times that of Hz to another; the units that messages name.
struct QuantityRow {
  std::string_view name;
  SheetQuantity quantity;
  double readings, hz;
  std::string_view gyro, accel;
};
constexpr std::string_view gyro_sizes = "deg/h, deg/s, mdps, rad/s", accel_sizes = "ug, mg, m/s^2";
constexpr std::array<QuantityRow, 8> quantities{{
    {"N", SheetQuantity::N, 1, -0.5, "deg/s/sqrt(Hz), mdps/sqrt(Hz), deg/h/sqrt(Hz), deg/sqrt(h), rad/s/sqrt(Hz)",
     "ug/sqrt(Hz), mg/sqrt(Hz), m/s/sqrt(h), m/s^2/sqrt(Hz)"},
    {"psd", SheetQuantity::psd, 2, -1, "(deg/s)^2/Hz, (rad/s)^2/Hz", "ug^2/Hz, g^2/Hz, (m/s^2)^2/Hz"},
    {"rms", SheetQuantity::rms, 1, 0, gyro_sizes, accel_sizes},
    {"bandwidth", SheetQuantity::bandwidth, 0, 1, "Hz, kHz", "Hz, kHz"},
    {"noise_bandwidth", SheetQuantity::noise_bandwidth, 0, 1, "Hz, kHz", "Hz, kHz"},
    {"B", SheetQuantity::B, 1, 0, gyro_sizes, accel_sizes},
    {"stability", SheetQuantity::stability, 1, 0, gyro_sizes, accel_sizes},
    {"K", SheetQuantity::K, 1, 0.5, "deg/h/sqrt(h), deg/s/sqrt(s), rad/s/sqrt(s)", "ug/sqrt(h), mg/sqrt(h), m/s^2/sqrt(s)"},
}};

UnitExpression unit_of(const QuantityRow& row, bool gyro) {
  const UnitExpression readings = gyro ? UnitExpression{1, 1, 0, -1} : UnitExpression{1, 0, 1, -2}, hz{1, 0, 0, -1};
  return UnitExpression().times(readings, row.readings).times(hz, row.hz);
}

/// "; it is a unit of gyro.N", where it is one of another quantity.
std::string other_quantity(const UnitExpression& unit, bool gyro) {
  for (const QuantityRow& row : quantities)
    if (unit.has_dimension_of(unit_of(row, gyro))) return fmt::format("; it is a unit of {}.{}", gyro ? "gyro" : "accel", row.name);
  return "";
}

double size_in_si(std::string_view unit, const QuantityRow& row, bool gyro) {
  const std::string_view accepted = gyro ? row.gyro : row.accel;
  if (unit.empty()) throw Error(fmt::format("has no unit; expected one such as {}", accepted));
  const std::optional<UnitExpression> found = parse_unit_expression(unit);
  if (!found) throw Error(fmt::format("\"{}\" is not a known unit; expected one such as {}", unit, accepted));
  if (!found->has_dimension_of(unit_of(row, gyro)))
    throw Error(fmt::format("\"{}\" is not a unit of {}{}; expected one such as {}", unit, row.name, other_quantity(*found, gyro), accepted));
  return found->size;
}

std::optional<SheetKind> kind_named(std::string_view word) {
  for (const std::string_view name : {"typical", "typ", "typ."})
    if (word == name) return SheetKind::typical;
  for (const std::string_view name : {"maximum", "max", "max."})
    if (word == name) return SheetKind::maximum;
  return std::nullopt;
}

/// Takes the last word of a unit that says what the value is, also in parentheses: "mg (rms)", "deg/s-rms max".
void take_last_word(std::string_view& unit, SheetKind& kind) {
  for (;;) {
    const std::size_t before = unit.find_last_of(" -("), begin = before == std::string_view::npos ? 0 : before + 1;
    const std::string last = lowered(trimmed(unit.substr(begin), ")"));
    const std::optional<SheetKind> named = kind_named(last);
    if (!named && last != "rms") return;
    if (named) kind = *named;
    unit = trimmed(unit.substr(0, begin == 0 ? 0 : before), sheet_blanks);
  }
}

/// A value's number and unit. Throws Error without the key, which the caller adds.
SheetEntry value_of(std::string_view text, const QuantityRow& row, bool gyro) {
  SheetEntry out{.gyro = gyro, .quantity = row.quantity};
  text = trimmed(text, sheet_blanks);
  for (const std::string_view sign : {"<=", "≤", "<"})
    if (text.starts_with(sign)) out.kind = SheetKind::maximum, text = trimmed(text.substr(sign.size()), sheet_blanks);
  if (is_decimal_comma(text, text.find(',')))
    throw Error(fmt::format("\"{}\": has a decimal comma; expected a point, as in 0.0038", text.substr(0, 60)));
  const auto [after, failure] = std::from_chars(text.data(), text.data() + text.size(), out.value);
  if (failure != std::errc() || !(out.value > 0) || !std::isfinite(out.value))
    throw Error(fmt::format("\"{}\": expected a number above 0 and its unit", text.substr(0, 60)));
  std::string_view unit = trimmed(text.substr(static_cast<std::size_t>(after - text.data())), sheet_blanks);
  take_last_word(unit, out.kind);
  out.value *= size_in_si(unit.substr(0, 60), row, gyro);
  return out;
}

void set_rate(DataSheet& sheet, std::string_view text) {
  constexpr QuantityRow rate{"rate", SheetQuantity::bandwidth, 0, 1, "Hz, kHz", "Hz, kHz"};
  sheet.rate_hz = value_of(text, rate, true).value;
}

void set_kind(DataSheet& sheet, std::string_view text) {
  const std::optional<SheetKind> kind = kind_named(lowered(text));
  if (!kind) throw Error(fmt::format("\"{}\" is not allowed; expected typical or maximum", text.substr(0, 60)));
  sheet.kind = *kind;
}

/// The parts of a key "gyro.x.N".
struct SheetKey {
  bool gyro = false;
  std::optional<std::size_t> axis;
  const QuantityRow* row = nullptr;
};

std::optional<SheetKey> parse_key(std::string_view key) {
  SheetKey out;
  const std::size_t dot = key.find('.');
  const std::string_view triad = key.substr(0, dot);
  if (dot == std::string_view::npos || (triad != "gyro" && triad != "accel")) return std::nullopt;
  out.gyro = triad == "gyro";
  key.remove_prefix(dot + 1);
  if (key.size() > 1 && key[1] == '.' && key[0] >= 'x' && key[0] <= 'z') out.axis = static_cast<std::size_t>(key[0] - 'x'), key.remove_prefix(2);
  for (const QuantityRow& row : quantities)
    if (row.name == key) out.row = &row;
  return out.row != nullptr ? std::optional(out) : std::nullopt;
}

std::vector<std::string> all_keys() {
  std::vector<std::string> out;
  for (const char* triad : {"gyro", "accel"})
    for (const QuantityRow& row : quantities) out.push_back(fmt::format("{}.{}", triad, row.name));
  for (const char* key : {"gyro.x.N", "rate", "kind", "name"}) out.emplace_back(key);
  return out;
}

/// "; did you mean gyro.N?", or the keys that there are.
std::string meant_or_nearest(std::string_view key) {
  const std::string meant = meant_noise_key(key);
  return meant.empty() ? expected_name(key, all_keys()) : fmt::format("; did you mean {}?", meant);
}

void add_entry(DataSheet& sheet, const SheetKey& key, std::string_view name, std::string_view value) {
  SheetEntry entry = value_of(value, *key.row, key.gyro);
  entry.axis = key.axis;
  entry.text = fmt::format("{} {}{}", name, value.starts_with('<') || value.starts_with("≤") ? "" : "= ", value);
  for (const SheetEntry& other : sheet.entries)
    if (other.gyro == entry.gyro && other.axis == entry.axis && other.quantity == entry.quantity)
      throw Error(fmt::format("is given twice: \"{}\"", other.text));
  sheet.entries.push_back(std::move(entry));
}

void read_assignment(DataSheet& sheet, std::string_view text) {
  const std::size_t sign = std::min(text.find_first_of("=<"), text.find("≤"));
  if (sign == std::string_view::npos)
    throw Error(fmt::format("\"{}\": expected KEY = NUMBER UNIT, as in \"gyro.N = 0.0038 deg/s/sqrt(Hz)\"", text.substr(0, 60)));
  const std::string key(trimmed(text.substr(0, sign), sheet_blanks));
  const std::string_view value = trimmed(text.substr(text[sign] == '=' ? sign + 1 : sign), sheet_blanks);
  const std::optional<SheetKey> parsed = parse_key(key);
  errors_at(key, [&] {
    if (parsed)
      add_entry(sheet, *parsed, key, value);
    else if (key == "rate")
      set_rate(sheet, value);
    else if (key == "kind")
      set_kind(sheet, value);
    else if (key == "name")
      sheet.name = value;
    else
      throw Error("is not a value of a data sheet" + meant_or_nearest(key));
  });
}

/// A key of TOML whose value is text; `use` gets it, and its Error is about the key.
template <class Use>
void with_text(text::TomlFields& f, std::string_view key, const Use& use) {
  std::optional<std::string> value;
  f.text(key, value);
  if (!value) return;
  try {
    use(*value);
  } catch (const Error& e) {
    f.check(false, key, e.what());
  }
}

void read_axis(text::TomlFields& f, DataSheet& sheet, const std::string& axis) {
  for (const QuantityRow& row : quantities)
    with_text(f, row.name, [&](const std::string& value) {
      const std::string key = fmt::format("{}.{}", axis, row.name);
      add_entry(sheet, *parse_key(key), key, value);
    });
}

}  // namespace

DataSheet parse_data_sheet(std::string_view text) {
  DataSheet out;
  while (!text.empty()) {
    std::size_t end = std::min(text.find_first_of(",;\n"), text.size());
    while (is_decimal_comma(text, end)) end = std::min(text.find_first_of(",;\n", end + 1), text.size());
    const std::string_view assignment = trimmed(text.substr(0, end), sheet_blanks);
    if (!assignment.empty()) read_assignment(out, assignment);
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  if (out.entries.empty()) throw Error("has no value; expected KEY = NUMBER UNIT, as in \"gyro.N = 0.0038 deg/s/sqrt(Hz)\"");
  return out;
}

DataSheet parse_data_sheet_file(std::string_view toml, const std::string& file) {
  DataSheet out;
  text::TomlFields root(file, toml);
  if (root.has("format")) root.format("imulab.datasheet/1");
  root.table("noise", fields::Presence::required, [&](text::TomlFields& f) {
    with_text(f, "rate", [&](const std::string& value) { set_rate(out, value); });
    with_text(f, "kind", [&](const std::string& value) { set_kind(out, value); });
    with_text(f, "name", [&](const std::string& value) { out.name = value; });
    for (const char* triad : {"gyro", "accel"})
      f.table(triad, fields::Presence::optional, [&](text::TomlFields& t) {
        read_axis(t, out, triad);
        for (const char* axis : {"x", "y", "z"})
          t.table(axis, fields::Presence::optional, [&](text::TomlFields& one) { read_axis(one, out, fmt::format("{}.{}", triad, axis)); });
      });
  });
  root.done();
  if (out.entries.empty()) throw Error(file + ": noise: has no value; expected keys such as gyro.N = \"0.0038 deg/s/sqrt(Hz)\"");
  return out;
}

DataSheet read_data_sheet(const std::string& text_or_file) {
  if (text_or_file.find_first_of("=<") != std::string::npos || text_or_file.find("≤") != std::string::npos) return parse_data_sheet(text_or_file);
  if (trimmed(text_or_file, sheet_blanks).empty()) return parse_data_sheet("");  // which says what is expected
  const bool values = text_or_file.starts_with("gyro.") || text_or_file.starts_with("accel.");
  if (std::error_code none; values && !std::filesystem::exists(text_or_file, none)) return parse_data_sheet(text_or_file);  // which refuses it
  const MappedFile file(text_or_file, Content::settings);
  if (trimmed(file.text(), sheet_blanks).starts_with('{'))
    throw Error(input_name(text_or_file) +
                ": is JSON; expected TOML with [noise]. A noise.json is what --datasheet writes: give it to `imulab export none --noise`");
  DataSheet out = parse_data_sheet_file(file.text(), input_name(text_or_file));
  if (out.name.empty()) out.name = input_name(text_or_file);
  return out;
}

}  // namespace imulab
