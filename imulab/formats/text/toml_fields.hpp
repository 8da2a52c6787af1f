// A TOML table, read key by key. Every key of the file must be read, and every value must have the right type and range; whatever is wrong throws
// Error as `FILE:LINE: KEY: what is wrong; expected WHAT`.
#pragma once

#include "imulab/core/fields.hpp"
#include "imulab/recording.hpp"
#include "imulab/session.hpp"

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace imulab::text {

/// A TOML text as JSON. Throws Error where it is not TOML.
std::string toml_as_json(std::string_view toml);

using namespace fields;

/// Each function reads one key into `value`, numbers converted to SI. A value stays as it is where an optional key is absent; optional are those of
/// std::optional values and of Presence::optional.
class TomlFields {
 public:
  using Body = std::function<void(TomlFields&)>;

  /// The root table of a file's text.
  TomlFields(const std::string& file, std::string_view text);
  ~TomlFields();

  /// Reads the required key `format` and expects `name`, for example "imulab.session/1".
  void format(std::string_view name);
  bool has(std::string_view key);
  void text(std::string_view key, std::string& value);
  void text(std::string_view key, std::optional<std::string>& value);
  void number(std::string_view key, double& value, const Number& kind);
  void number(std::string_view key, std::optional<double>& value, const Number& kind);
  double number_or(std::string_view key, double otherwise, const Number& kind);  ///< `otherwise` in SI
  void numbers(std::string_view key, std::span<double> values, const Number& kind);
  template <std::size_t N>
  void array(std::string_view key, std::optional<std::array<double, N>>& value, const Number& kind) {
    std::array<double, N> given{};
    const bool there = has(key);
    numbers(key, given, or_default(kind));
    if (there) value = given;
  }
  void pair(std::string_view key, std::optional<std::array<double, 2>>& value, const Number& kind) { array(key, value, kind); }
  void triple(std::string_view key, std::optional<std::array<double, 3>>& value, const Number& kind) { array(key, value, kind); }
  void pairs(std::string_view key, std::vector<std::array<double, 2>>& values, const Number& kind);  ///< a list of pairs; absent: none
  void number_or_numbers(std::string_view key, std::span<double> values, const Number& kind);        ///< one number counts for all
  void spread(std::string_view key, Spread& value, double factor);                                   ///< a number, or { fixed = a number }
  /// One of `values`, by to_string.
  template <class Enum>
  void choice(std::string_view key, Enum& value, const std::vector<Enum>& values, Presence presence = Presence::required) {
    std::vector<std::string_view> names;
    names.reserve(values.size());
    for (const Enum v : values) names.push_back(to_string(v));
    std::size_t index = names.size();
    choose(key, names, presence, index);
    if (index < names.size()) value = values[index];
  }
  void choice(std::string_view key, std::string& value, const std::vector<std::string_view>& names, Presence presence);
  void column(std::string_view key, std::optional<Column>& value);
  void columns(std::string_view key, std::vector<Column>& value, const std::vector<std::size_t>& counts);  ///< as many as one of `counts`
  void axis(std::string_view key, std::optional<BodyAxis>& value);
  void axes(std::string_view key, std::optional<std::array<BodyAxis, 3>>& value);
  void clock_zero(std::string_view key, std::int64_t& zero_ns, int exponent);  ///< in units of 10^exponent ns, exactly
  bool table(std::string_view key, Presence presence, const Body& body);       ///< false where it is absent
  template <class T>
  void table_of(std::string_view key, std::optional<T>& value, const std::function<void(TomlFields&, T&)>& body) {
    table(key, Presence::optional, [&](TomlFields& fields) { body(fields, value.emplace()); });
  }
  void tables(std::string_view key, const Body& body);  ///< [[key]], or one [key]; an Error lists what is wrong in all of them
  /// Tables that follow from those before: what is wrong in the first is all that is known.
  void consecutive_tables(std::string_view key, const Body& body);

  /// Throws Error with `message` about the key (at the table's line where the key is absent) unless good; about a required key that is missing
  /// instead, if one was. So what follows a check may rely on it.
  void check(bool good, std::string_view key, const std::string& message) const;
  /// Throws Error where the file has a key that was not read, or a required one is missing.
  void done() const;

 private:
  struct Node;  // hides toml++
  explicit TomlFields(std::unique_ptr<Node> node);
  void read_tables(std::string_view key, const Body& body, bool all);
  void choose(std::string_view key, const std::vector<std::string_view>& names, Presence presence, std::size_t& index);

  std::unique_ptr<Node> node_;
};

}  // namespace imulab::text
