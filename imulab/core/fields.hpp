// Fields of tables and results: their presence, unit and range. describe(fields, value), beside a result's struct, names each field of the result
// once; what writes, reads or lists it is a visitor (formats/text/json_fields.hpp), which has `reads`, (key, value, how) and table(key, describe,
// how).
#pragma once

#include <limits>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace imulab::fields {

enum class Presence { required, optional };

/// A number's unit and range: multiplied by the factor it is in SI; the range is in the file's unit.
struct Number {
  double factor = 1;
  double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
  bool above_low = false;  ///< low itself is excluded
  Presence presence = Presence::required;
};

inline Number any_number(double factor = 1) { return {factor}; }
inline Number positive(double factor = 1) { return {factor, 0, std::numeric_limits<double>::infinity(), true}; }
inline Number not_negative(double factor = 1) { return {factor, 0}; }
inline Number within(double low, double high, double factor = 1) { return {factor, low, high}; }
inline Number or_default(Number number) {
  number.presence = Presence::optional;
  return number;
}

/// True for a number in the file's unit that is in its range.
bool in_range(double value, const Number& kind);
/// "100 is out of range; expected -90 to 90"
std::string out_of_range(double value, const Number& kind);

/// The value that null in a file stands for; empty: a number 0, or an empty text.
enum class Null { none, nan, infinity, empty };

/// The manner in which a field of a result is written and read.
struct How {
  Presence presence = Presence::required;  ///< of the key in a file; optional: the value keeps what it has where the key is absent
  Null null = Null::none;
  bool left_out = false;           ///< where there is none (an empty text or list, an absent optional) the key is not written
  double size = 1;                 ///< of the file's unit in SI
  const char* things = "numbers";  ///< elements of a list of a certain length, in messages
  int digits = 0;                  ///< significant digits of a number that only a picture needs; 0: all
};
inline constexpr How optional{Presence::optional}, or_nan{Presence::required, Null::nan}, or_infinity{Presence::required, Null::infinity},
    or_empty{Presence::optional, Null::empty}, if_any{Presence::optional, Null::none, true}, if_known{Presence::optional, Null::nan};
inline constexpr How in(double size) { return {Presence::required, Null::none, false, size}; }

/// Where what was read is not right, the visitor's Error says so at the key, or without one at the object itself.
template <class Fields>
void check(Fields& f, bool right, std::string_view key, const std::string& text) {
  if constexpr (Fields::reads)
    if (!right) f.attempt([&] { (key.empty() ? f.at() : f.at()[key]).fail(text); });
}
/// The message also has what was found.
template <class Fields>
void expect(Fields& f, bool right, std::string_view key, const std::string& what) {
  if constexpr (Fields::reads)
    if (!right) f.attempt([&] { f.at()[key].expected(what); });
}

/// A key that no description before it has named is refused; where others are allowed only one that looks like a mistyped one. For a reader that
/// collects problems.
template <class Fields>
void known_keys_only(Fields& f, bool others_allowed = false) {
  if constexpr (Fields::reads) f.expect_known_keys(others_allowed);
}

/// A field that follows from others: written, not read.
template <class Fields, class Value>
void derived(Fields& f, std::string_view key, const Value& value, const How& how = {}) {
  if constexpr (Fields::reads)
    f.knows(key);
  else
    f(key, value, how);
}

/// A field that is no member: get() is written, set(value) is called with what was read.
template <class Fields, class Get, class Set>
void via(Fields& f, std::string_view key, const Get& get, const Set& set, const How& how = {}) {
  if constexpr (Fields::reads) {
    std::decay_t<std::invoke_result_t<Get>> value{};
    if (f(key, value, how)) set(value);
  } else {
    f(key, get(), how);
  }
}

/// One of some values by their names; `names` as in a message: "free, fixed or aided".
template <class Fields, class Enum, class Values>
void choice(Fields& f, std::string_view key, Enum& value, const Values& values, const std::string& names, const How& how = {}) {
  const auto set = [&](const std::string& name) {
    for (const Enum each : values)
      if (to_string(each) == name) return void(value = each);
    expect(f, false, key, names);
  };
  via(
      f, key, [&] { return std::string(to_string(value)); }, set, how);
}

/// A list of one number of each row, number(row). The first of several columns makes the rows.
template <class Fields, class Row, class Number>
void column(Fields& f, std::string_view key, std::vector<Row>& rows, bool first, const How& how, const Number& number) {
  const auto get = [&] {
    std::vector<double> list;
    for (Row& row : rows) list.push_back(static_cast<double>(number(row)));
    return list;
  };
  const auto set = [&](const std::vector<double>& list) {
    if (first) rows.resize(list.size());
    check(f, list.size() == rows.size(), key, "expected " + std::to_string(rows.size()) + " numbers");
    for (std::size_t i = 0; i < rows.size(); ++i) {
      using Type = std::decay_t<decltype(number(rows[i]))>;
      if constexpr (std::is_integral_v<Type>)
        check(f, list[i] >= (std::is_unsigned_v<Type> ? 0 : -1e9) && list[i] <= 1e9, key, "expected whole numbers");
      number(rows[i]) = static_cast<Type>(list[i]);
    }
  };
  via(f, key, get, set, how);
}

}  // namespace imulab::fields
