// JSON: values to write, the parser, and reading with messages that name file, path and what was expected. Only json.cpp includes a JSON library.
#pragma once

#include "imulab/error.hpp"

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <ranges>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace imulab {

/// A text that does not even begin as JSON: another file in the place of one.
class NotJson : public Error {
 public:
  using Error::Error;
};

struct JsonValue;

/// An object: keys and values in their order.
struct JsonFields {
  std::vector<std::pair<std::string, JsonValue>> fields;
};

/// A number that is not finite is written as null.
struct JsonValue {
  std::variant<std::nullptr_t, bool, std::int64_t, std::uint64_t, double, std::string, std::vector<JsonValue>, JsonFields> is;

  JsonValue() = default;  ///< null
  JsonValue(std::nullptr_t) {}
  template <std::integral Number>
  JsonValue(Number number) {
    if constexpr (std::same_as<Number, bool>)
      is = number;
    else if constexpr (std::signed_integral<Number>)
      is = std::int64_t{number};
    else
      is = std::uint64_t{number};
  }
  template <std::floating_point Number>
  JsonValue(Number number) : is(double{number}) {}
  JsonValue(std::string text) : is(std::move(text)) {}
  JsonValue(std::string_view text) : is(std::string(text)) {}
  JsonValue(const char* text) : is(std::string(text)) {}
  JsonValue(JsonFields object) : is(std::move(object)) {}
  JsonValue(std::vector<JsonValue> list) : is(std::move(list)) {}
  template <class Value>
  JsonValue(const std::optional<Value>& value) {
    if (value) *this = JsonValue(*value);
  }
  /// A list.
  template <std::ranges::input_range Range>
  requires(!std::convertible_to<const Range&, std::string> && !std::convertible_to<const Range&, std::string_view>) JsonValue(const Range& range)
      : is(std::vector<JsonValue>()) {
    for (const auto& element : range) std::get<std::vector<JsonValue>>(is).emplace_back(element);
  }
};

enum class JsonLayout {
  indented,      ///< an element a line
  one_line,      ///< without blanks
  long_lists,    ///< an element a line, but lists of many numbers on one line
  rows_on_lines  ///< an element a line, but lists of plain values on one line
};
/// Ends in a newline.
std::string json_text(const JsonValue& value, JsonLayout layout = JsonLayout::indented);
inline std::string fields_json(const JsonFields& object, bool one_line = false) {
  return json_text(object, one_line ? JsonLayout::one_line : JsonLayout::indented);
}

}  // namespace imulab

namespace imulab::json_io {

enum class Keys { any, once };

/// Throws Error where the text is not JSON, or nested deeper than any result; `what` is expected: "a calibration". Of a key that is given twice the
/// last value counts, or, where keys are expected `once`, an Error says so.
JsonValue parse_json(std::string_view text, const std::string& file, const std::string& what, Keys keys = Keys::any);

/// A value in a JSON file and the path that leads to it, which every message names.
class Field {
 public:
  Field(const JsonValue& value, std::string file, std::string path) : value_(value), file_(std::move(file)), path_(std::move(path)) {}

  [[noreturn]] void fail(const std::string& text) const;
  [[noreturn]] void expected(const std::string& what) const;

  std::vector<std::string> keys() const;  ///< of an object, in the file's order
  bool is_null() const { return std::holds_alternative<std::nullptr_t>(value_.is); }
  bool has(std::string_view key) const;
  Field operator[](std::string_view key) const;
  std::size_t size() const;  ///< of a list
  /// Element i of a list of `count` things.
  Field item(std::size_t i, std::size_t count, const char* things) const;

  double number() const;
  double number_or_nan() const { return is_null() ? std::numeric_limits<double>::quiet_NaN() : number(); }
  double number_or_infinity() const { return is_null() ? std::numeric_limits<double>::infinity() : number(); }
  int whole_number() const;
  std::uint64_t size_in_bytes() const;
  bool truth() const;
  std::string text() const;
  template <class Read>
  auto list(Read read) const {
    std::vector<decltype(read(*this))> out;
    for (std::size_t i = 0, n = size(); i < n; ++i) out.push_back(read(item(i, n, "elements")));
    return out;
  }
  std::vector<std::string> texts() const;
  std::vector<std::string> texts(std::string_view key) const;  ///< an absent list is empty

 private:
  const JsonValue* find(std::string_view key) const;

  const JsonValue& value_;
  std::string file_, path_;
};

/// The faults of a file, part after part: all of them are one Error, a line each.
class Problems {
 public:
  /// True where `read` found none in its part.
  template <class Read>
  bool none_in(const Read& read) {
    try {
      read();
      return true;
    } catch (const Error& e) {
      add(e.what());
      return false;
    }
  }
  void expect_none() const;
  /// A key that is not of the format is refused; where others are allowed only one that is nearly, from its first letter on, a key that is missing:
  /// it would be left out without a word.
  void expect_known_keys(const Field& field, const std::vector<std::string_view>& known, bool others_allowed);

 private:
  void add(const std::string& text);

  std::vector<std::string> texts_;
  std::size_t more_ = 0;
};

}  // namespace imulab::json_io
