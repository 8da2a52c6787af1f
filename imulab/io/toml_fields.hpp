// One TOML table being read: every key must be asked for, every value must be of the right kind and range, and every problem is reported as
// `file:line: field: what is wrong, expected ...`.
#pragma once

#include "imulab/io/field.hpp"
#include "imulab/recording/session.hpp"

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

class TomlFields {
 public:
  using Body = std::function<void(TomlFields&)>;

  /// The root table of a file's text.
  TomlFields(const std::string& file, std::string_view text);
  ~TomlFields();

  bool has(std::string_view key);
  void text(std::string_view key, std::string& value);
  void text(std::string_view key, std::optional<std::string>& value);
  void number(std::string_view key, double& value, const Number& kind);
  void number(std::string_view key, std::optional<double>& value, const Number& kind);
  void numbers(std::string_view key, std::span<double> values, const Number& kind);
  void pair(std::string_view key, std::optional<std::array<double, 2>>& value, const Number& kind);
  void number_or_numbers(std::string_view key, std::span<double> values, const Number& kind);  ///< one number stands for all
  void spread(std::string_view key, Spread& value, double factor);
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
  void column(std::string_view key, Column& value);
  void columns(std::string_view key, std::vector<Column>& value, const std::vector<std::size_t>& counts);
  void axis(std::string_view key, std::optional<BodyAxis>& value);
  void clock_zero(std::string_view key, std::int64_t& zero_ns, int exponent);  ///< in units of 10^exponent ns, exactly
  bool table(std::string_view key, Presence presence, const Body& body);       ///< false where it is absent
  template <class T>
  void table_of(std::string_view key, std::optional<T>& value, const std::function<void(TomlFields&, T&)>& body) {
    table(key, Presence::optional, [&](TomlFields& fields) { body(fields, value.emplace()); });
  }
  void tables(std::string_view key, const Body& body);  ///< [[key]], or one [key]

  /// Throws the message about the key (with the table's line where the key is absent) unless good.
  void check(bool good, std::string_view key, const std::string& message) const;
  /// Throws where a key was not asked for, or a required one is missing.
  void done() const;

 private:
  struct Node;  // hides toml++
  explicit TomlFields(std::unique_ptr<Node> node);
  void choose(std::string_view key, const std::vector<std::string_view>& names, Presence presence, std::size_t& index);

  std::unique_ptr<Node> node_;
};

}  // namespace imulab
