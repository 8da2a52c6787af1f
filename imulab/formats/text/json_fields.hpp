// Descriptions as JSON: describe(fields, value) writes it where `fields` is a JsonWriter, and reads it where it is a JsonReader.
//
//   struct Turn { std::string axis; double angle = 0; std::vector<double> rests; };
//   template <class Fields>
//   void describe(Fields& f, Turn& turn) {
//     f("axis", turn.axis), f("angle_deg", turn.angle, fields::in(unit::deg));
//     f("rests_s", turn.rests, fields::optional);  // absent from files of earlier versions
//   }
//   json_text(written(turn));
//   read_into(field, turn);
#pragma once

#include "imulab/coefficient.hpp"
#include "imulab/core/fields.hpp"
#include "imulab/formats/text/json.hpp"

#include <array>

namespace imulab {

namespace json_io {

template <class Fields, class Value>
concept Described = requires(Fields& f, Value& value) {
  describe(f, value);
};
template <class Value>
concept Optional = requires(const Value& v) {
  v.has_value();
};
template <class Value>
concept Text = std::same_as<Value, std::string> || std::same_as<Value, std::string_view>;
template <class Value>
concept Matrix = requires {
  Value::ColsAtCompileTime;
};
template <class Value>
concept List = std::ranges::range<const Value> && !std::convertible_to<const Value&, std::string_view>;
template <class Value>
concept Keyed = requires(const Value& v) {
  requires std::same_as<std::remove_cvref_t<decltype(v.begin()->first)>, std::string>;
};  // pairs of a key and a value: an object

double with_digits(double value, int digits);
double read_number(const Field& at, const fields::How& how);
CoefficientIndex coefficient_of(const Field& parent, const std::string& name);

}  // namespace json_io

template <class Value>
JsonValue written(const Value& value, const fields::How& how = {});

class JsonWriter {
 public:
  static constexpr bool reads = false;
  JsonFields out;

  template <class Value>
  void operator()(std::string_view key, const Value& value, const fields::How& how = {}) {
    if constexpr (json_io::Optional<Value>) {
      if (how.left_out && !value) return;
    } else if constexpr (json_io::Matrix<Value>) {
      if (how.left_out && value.isZero(0)) return;
    } else if constexpr (requires { value.empty(); }) {
      if (how.left_out && value.empty()) return;
    }
    out.fields.emplace_back(key, written(value, how));
  }
  /// An object that is no member: describe_table(fields) names its fields.
  template <class Describe>
  void table(std::string_view key, const Describe& describe_table, const fields::How& = {}) {
    JsonWriter inner;
    describe_table(inner);
    out.fields.emplace_back(key, std::move(inner.out));
  }
};

/// Stops at the first problem, or collects all where it is given `problems`.
class JsonReader {
 public:
  static constexpr bool reads = true;
  explicit JsonReader(json_io::Field object, json_io::Problems* problems = nullptr) : at_(std::move(object)), problems_(problems) {}
  const json_io::Field& at() const { return at_; }

  template <class Read>
  bool attempt(const Read& read) const {
    if (problems_ != nullptr) return problems_->none_in(read);
    read();
    return true;
  }
  void knows(std::string_view key) { known_.push_back(key); }
  void expect_known_keys(bool others_allowed) const {
    if (problems_ != nullptr) problems_->expect_known_keys(at_, known_, others_allowed);
  }

  /// True where the key is there, and right.
  template <class Value>
  bool operator()(std::string_view key, Value& value, const fields::How& how = {}) {
    knows(key);
    if (how.presence == fields::Presence::optional && !at_.has(key)) return false;
    return attempt([&] { read(at_[key], value, how); });
  }
  template <class Describe>
  void table(std::string_view key, const Describe& describe_table, const fields::How& how = {}) {
    knows(key);
    if (how.presence == fields::Presence::optional && !at_.has(key)) return;
    attempt([&] {
      JsonReader inner(at_[key], problems_);
      describe_table(inner);
    });
  }

  template <class Value>
  void read(const json_io::Field& at, Value& value, const fields::How& how = {}) const {
    if constexpr (json_io::Described<JsonReader, Value>) {
      JsonReader inner(at, problems_);
      describe(inner, value);
    } else if constexpr (json_io::Optional<Value>) {
      value.reset();
      if (!at.is_null()) read(at, value.emplace(), how);
    } else if constexpr (json_io::Keyed<Value>) {
      for (const std::string& key : at.keys()) {
        std::remove_cvref_t<decltype(value.begin()->second)> item{};
        read(at[key], item, how);
        value.insert(value.end(), {key, std::move(item)});
      }
    } else if constexpr (json_io::Matrix<Value>) {
      const auto rows = static_cast<std::size_t>(value.rows()), columns = static_cast<std::size_t>(value.cols());
      for (std::size_t i = 0; i < rows; ++i)
        for (std::size_t j = 0; j < columns; ++j)
          value(static_cast<int>(i), static_cast<int>(j)) = json_io::read_number(
              Value::ColsAtCompileTime == 1 ? at.item(i, rows, "numbers")
                                            : at.item(i, rows, columns == 4 ? "rows of 4 numbers" : "rows of 3 numbers").item(j, columns, "numbers"),
              how);
    } else if constexpr (json_io::List<Value>) {
      if constexpr (requires { value.resize(0); }) value.clear(), value.resize(at.size());
      for (std::size_t i = 0; i < value.size(); ++i) read(at.item(i, value.size(), how.things), value[i], how);
    } else {
      read_plain(at, value, how);
    }
  }

 private:
  template <class Value>
  static void read_plain(const json_io::Field& at, Value& value, const fields::How& how) {
    if constexpr (std::same_as<Value, double>) value = json_io::read_number(at, how);
    if constexpr (std::same_as<Value, bool>) value = at.truth();
    if constexpr (std::same_as<Value, int>) value = at.whole_number();
    if constexpr (std::same_as<Value, std::uint64_t>) value = at.size_in_bytes();
    if constexpr (std::same_as<Value, std::string>) value = at.is_null() && how.presence == fields::Presence::optional ? "" : at.text();
    if constexpr (std::same_as<Value, CoefficientIndex>) value = json_io::coefficient_of(at, at.text());
  }

  json_io::Field at_;
  json_io::Problems* problems_;
  std::vector<std::string_view> known_;  // keys of the description
};

template <class Value>
JsonValue written(const Value& value, const fields::How& how) {
  if constexpr (json_io::Described<JsonWriter, Value>) {
    JsonWriter writer;
    describe(writer, const_cast<Value&>(value));  // a description changes its value only where it reads
    return std::move(writer.out);
  } else if constexpr (json_io::Optional<Value>) {
    return value ? written(*value, how) : JsonValue();
  } else if constexpr (std::same_as<Value, double>) {
    return how.null == fields::Null::empty && value == 0 ? JsonValue() : JsonValue(json_io::with_digits(value / how.size, how.digits));
  } else if constexpr (json_io::Text<Value>) {
    return how.null == fields::Null::empty && value.empty() ? JsonValue() : JsonValue(value);
  } else if constexpr (std::same_as<Value, CoefficientIndex>) {
    return coefficient(value).name;
  } else if constexpr (json_io::Keyed<Value>) {
    JsonFields object;
    for (const auto& [key, item] : value) object.fields.emplace_back(key, written(item, how));
    return object;
  } else if constexpr (json_io::Matrix<Value> || json_io::List<Value>) {
    std::vector<JsonValue> list;
    if constexpr (!json_io::Matrix<Value>)
      for (const auto& element : value) list.push_back(written(element, how));
    else if constexpr (Value::ColsAtCompileTime == 1)
      for (const double element : value) list.push_back(written(element, how));
    else
      for (const auto& row : value.rowwise()) list.push_back(written(std::vector<double>(row.begin(), row.end()), how));
    return list;
  } else {
    return value;
  }
}

/// Reads a described value; the Error names the field that is wrong.
template <class Value>
void read_into(const json_io::Field& at, Value& value) {
  JsonReader(at).read(at, value);
}

/// An object of values by their names: `name`, or that of the coefficient `index`.
template <class Fields, class Value>
void describe_by_name(Fields& f, std::string_view key, std::vector<Value>& values, const fields::How& how = {}) {
  if (!Fields::reads && how.left_out && values.empty()) return;
  const auto all = [&](auto& inner) {
    constexpr bool is_named = requires(Value & v) { v.name; };
    if constexpr (Fields::reads) {
      for (const std::string& name : inner.at().keys()) {
        Value& value = values.emplace_back();
        if constexpr (is_named)
          value.name = name;
        else
          value.index = json_io::coefficient_of(inner.at(), name);
        inner.read(inner.at()[name], value);
      }
    } else {
      for (Value& value : values)
        if constexpr (is_named)
          inner(value.name, value);
        else
          inner(coefficient(value.index).name, value);
    }
  };
  f.table(key, all, how);
}

}  // namespace imulab
