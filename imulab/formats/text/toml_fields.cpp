#include "imulab/formats/text/toml_fields.hpp"

#include "imulab/core/nearest_name.hpp"
#include "imulab/core/unit_expression.hpp"
#include "imulab/error.hpp"
#include "imulab/formats/text/decimal.hpp"
#include "imulab/formats/text/printable.hpp"

#include <fmt/core.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <sstream>
#include <utility>

namespace imulab::text {

struct TomlFields::Node {
  std::string file;
  std::string_view text;  // of the whole file
  toml::table root;       // of the outermost table only
  const toml::table* table = nullptr;
  std::string path;  // "recording.gyro"
  std::vector<std::string_view> asked;
  std::string missing;  // the first missing key; reported last, since a misspelt key explains it

  std::string name(std::string_view key) const { return path.empty() ? excerpt(key) : fmt::format("{}.{}", path, excerpt(key)); }
  const toml::node* find(std::string_view key, Presence presence) {
    if (std::find(asked.begin(), asked.end(), key) == asked.end()) asked.push_back(key);
    const toml::node* node = table->get(key);
    if (node == nullptr && presence == Presence::required && missing.empty()) missing = key;
    return node;
  }
  [[noreturn]] void fail(const toml::node& node, std::string_view key, const std::string& message) const {
    throw Error(fmt::format("{}:{}: {}: {}", file, node.source().begin.line, name(key), message));
  }
  /// A key that resembles the missing one is a misspelt one.
  [[noreturn]] void fail_missing() const {
    for (const auto& [key, value] : *table)
      if (std::find(asked.begin(), asked.end(), key.str()) == asked.end() && !nearest_name(key.str(), {missing}).empty())
        throw Error(fmt::format("{}:{}: {}: is not a known key; did you mean {}?", file, key.source().begin.line, name(key.str()), missing));
    throw Error(fmt::format("{}:{}: {}: is missing", file, std::max(table->source().begin.line, 1U), name(missing)));
  }
  double number(const toml::node& node, std::string_view key, const Number& kind) const {
    const auto integer = node.value_exact<std::int64_t>();
    const std::optional<double> value = integer ? static_cast<double>(*integer) : node.value_exact<double>();
    if (!value) fail(node, key, fmt::format("{}; expected a number", kind_of(node)));
    if (!std::isfinite(*value)) fail(node, key, "is not finite; expected a finite number");
    if (!in_range(*value, kind)) fail(node, key, out_of_range(*value, kind));
    constexpr double largest = 1e30, smallest = 1e-30;  // products of a few such numbers are still numbers
    if (std::abs(*value) > largest || (kind.above_low && *value < smallest))
      fail(node, key, fmt::format("{} is out of range; expected {} to {}", *value, kind.above_low ? smallest : -largest, largest));
    return *value * kind.factor;
  }
  Column column(const toml::node& node, std::string_view key) const {
    if (const auto column_name = node.value_exact<std::string>()) return *column_name;
    const auto index = node.value_exact<std::int64_t>();
    if (!index) fail(node, key, fmt::format("{}; expected a column's name or its number", kind_of(node)));
    if (*index < 1 || *index > 1'000'000) fail(node, key, fmt::format("column {} is out of range; expected 1 or more", *index));
    return static_cast<int>(*index);
  }
  /// The value's own text, for a number that a double would round.
  std::string lexeme(const toml::node& node) const {
    const auto [begin, end] = std::pair(node.source().begin, node.source().end);
    std::string_view rest = text;
    for (std::uint32_t line = 1; line < begin.line; ++line) rest.remove_prefix(std::min(rest.find('\n'), rest.size() - 1) + 1);
    if (begin.line != end.line || end.column <= begin.column || begin.column > rest.size()) return {};
    std::string digits(rest.substr(begin.column - 1, end.column - begin.column));
    std::erase(digits, '_');
    return digits;
  }
  static std::string kind_of(const toml::node& node) {
    return fmt::format("is {}", node.is_string()    ? "text"
                                : node.is_number()  ? "a number"
                                : node.is_array()   ? "a list"
                                : node.is_table()   ? "a table"
                                : node.is_boolean() ? "true or false"
                                                    : "a date or time");
  }
};

namespace {

constexpr std::size_t longest_reason = 200;  // characters of a library's message, which may quote the file

/// The parser calls itself for every part of a dotted key: throws Error, before it does, for a key of more parts than any file of ours has. Text in
/// quotes is one part.
void expect_shallow_keys(const std::string& file, std::string_view text) {
  constexpr int most_parts = 32;
  int line = 1, dots = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '\n') ++line;
    if (c == '#') {
      i = std::min(text.find('\n', i), text.size()) - 1;
    } else if (c == '"' || c == '\'') {
      const std::size_t end = text.find_first_of(c == '"' ? "\"\n" : "'\n", i + 1);
      i = (end == std::string_view::npos ? text.size() : end) - (end != std::string_view::npos && text[end] == '\n' ? 1 : 0);
    } else if (c == '.') {
      if (++dots >= most_parts) throw Error(fmt::format("{}:{}: a key has more than {} parts; expected fewer", file, line, most_parts));
    } else if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '_' && c != '-' && c != ' ' && c != '\t') {
      dots = 0;
    }
  }
}

}  // namespace

TomlFields::TomlFields(const std::string& file, std::string_view text) : node_(std::make_unique<Node>()) {
  node_->file = file;
  node_->text = text;
  expect_shallow_keys(file, text);
  const auto nul = std::find(text.begin(), text.end(), '\0');
  if (nul != text.end()) throw Error(fmt::format("{}:{}: a byte is 0 (NUL); expected text (TOML)", file, 1 + std::count(text.begin(), nul, '\n')));
  try {
    node_->root = toml::parse(text, file);
  } catch (const toml::parse_error& e) {
    throw Error(fmt::format("{}:{}: {}; expected TOML", file, e.source().begin.line, excerpt(e.description(), longest_reason)));
  }
  node_->table = &node_->root;
}

TomlFields::TomlFields(std::unique_ptr<Node> node) : node_(std::move(node)) {}
TomlFields::~TomlFields() = default;

void TomlFields::format(std::string_view name) {
  const std::size_t dot = name.find('.') + 1, slash = name.find('/');
  std::string found;
  text("format", found);
  const bool same_kind = found.starts_with(name.substr(0, slash + 1));
  check(found == name, "format",
        fmt::format("\"{}\" is {}; expected \"{}\"", excerpt(found),
                    same_kind ? "a format this version does not know" : fmt::format("not a {}", name.substr(dot, slash - dot)), name));
}

bool TomlFields::has(std::string_view key) { return node_->table->contains(key); }

void TomlFields::text(std::string_view key, std::optional<std::string>& value) {
  const toml::node* node = node_->find(key, Presence::optional);
  if (node == nullptr) return;
  value = node->value_exact<std::string>();
  if (!value) node_->fail(*node, key, Node::kind_of(*node) + "; expected text in quotes");
  if (value->empty()) node_->fail(*node, key, "is empty; expected text");
}

void TomlFields::text(std::string_view key, std::string& value) {
  node_->find(key, Presence::required);
  std::optional<std::string> found;
  text(key, found);
  if (found) value = *found;
}

void TomlFields::number(std::string_view key, double& value, const Number& kind) {
  if (const toml::node* node = node_->find(key, kind.presence)) value = node_->number(*node, key, kind);
}

void TomlFields::number(std::string_view key, std::optional<double>& value, const Number& kind) {
  if (const toml::node* node = node_->find(key, Presence::optional)) value = node_->number(*node, key, kind);
}

double TomlFields::number_or(std::string_view key, double otherwise, const Number& kind) {
  std::optional<double> given;
  number(key, given, kind);
  return given.value_or(otherwise);
}

void TomlFields::numbers(std::string_view key, std::span<double> values, const Number& kind) {
  const toml::node* node = node_->find(key, kind.presence);
  if (node == nullptr) return;
  const toml::array* list = node->as_array();
  if (list == nullptr) node_->fail(*node, key, fmt::format("{}; expected {} numbers in brackets", Node::kind_of(*node), values.size()));
  if (list->size() != values.size()) node_->fail(*node, key, fmt::format("{} numbers; expected {}", list->size(), values.size()));
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = node_->number(*list->get(i), key, kind);
}

void TomlFields::pairs(std::string_view key, std::vector<std::array<double, 2>>& values, const Number& kind) {
  const toml::node* node = node_->find(key, Presence::optional);
  if (node == nullptr) return;
  const toml::array* list = node->as_array();
  for (std::size_t i = 0; list != nullptr && i < list->size(); ++i) {
    const toml::array* pair = list->get(i)->as_array();
    if (pair == nullptr || pair->size() != 2) list = nullptr;
    if (list != nullptr) values.push_back({node_->number(*pair->get(0), key, kind), node_->number(*pair->get(1), key, kind)});
  }
  if (list == nullptr) node_->fail(*node, key, "is no list of pairs of numbers; expected one, as in [[300, 360], [600, 660]]");
}

void TomlFields::number_or_numbers(std::string_view key, std::span<double> values, const Number& kind) {
  const toml::node* node = node_->table->get(key);
  if (node == nullptr || node->is_array()) return numbers(key, values, kind);
  double value = 0;
  number(key, value, kind);
  std::fill(values.begin(), values.end(), value);
}

void TomlFields::spread(std::string_view key, Spread& value, double factor) {
  const toml::node* node = node_->find(key, Presence::optional);
  if (node == nullptr) return;
  if (!node->is_table()) {
    value = {node_->number(*node, key, not_negative(factor)), false};
    return;
  }
  value.fixed = true;
  table(key, Presence::optional, [&](TomlFields& fields) { fields.number("fixed", value.value, any_number(factor)); });
}

void TomlFields::choose(std::string_view key, const std::vector<std::string_view>& names, Presence presence, std::size_t& index) {
  const toml::node* node = node_->find(key, presence);
  if (node == nullptr) return;
  const auto word = node->value_exact<std::string>();
  if (!word) node_->fail(*node, key, fmt::format("{}; expected one of {}", Node::kind_of(*node), listed(names)));
  auto found = std::find(names.begin(), names.end(), *word);
  if (found == names.end())  // "dps" is "deg/s"
    found = std::find_if(names.begin(), names.end(), [&](std::string_view name) { return is_same_unit(*word, name); });
  if (found == names.end()) node_->fail(*node, key, fmt::format("\"{}\" is not allowed; expected one of {}", excerpt(*word), listed(names)));
  index = static_cast<std::size_t>(found - names.begin());
}

void TomlFields::choice(std::string_view key, std::string& value, const std::vector<std::string_view>& names, Presence presence) {
  std::size_t index = names.size();
  choose(key, names, presence, index);
  if (index < names.size()) value = names[index];
}

void TomlFields::column(std::string_view key, std::optional<Column>& value) {
  const toml::node* node = node_->find(key, Presence::optional);
  value = node != nullptr ? std::optional(node_->column(*node, key)) : std::nullopt;
}

void TomlFields::columns(std::string_view key, std::vector<Column>& value, const std::vector<std::size_t>& counts) {
  const toml::node* node = node_->find(key, Presence::required);
  if (node == nullptr) return;
  std::string expected;
  for (const std::size_t count : counts) expected += fmt::format("{}{}", expected.empty() ? "" : " or ", count);
  const toml::array* list = node->as_array();
  if (list == nullptr) node_->fail(*node, key, fmt::format("{}; expected a list of {} columns", Node::kind_of(*node), expected));
  if (std::find(counts.begin(), counts.end(), list->size()) == counts.end())
    node_->fail(*node, key, fmt::format("{} column{}; expected {}", list->size(), list->size() == 1 ? "" : "s", expected));
  value.clear();
  for (const toml::node& element : *list) {
    const Column column = node_->column(element, key);
    if (std::find(value.begin(), value.end(), column) != value.end())
      node_->fail(*node, key, "names the same column twice; expected different columns");
    value.push_back(column);
  }
}

void TomlFields::axis(std::string_view key, std::optional<BodyAxis>& value) {
  static const std::vector<std::string_view> names{"+x", "+y", "+z", "-x", "-y", "-z"};
  std::size_t index = names.size();
  choose(key, names, Presence::optional, index);
  if (index < names.size()) value = BodyAxis{static_cast<int>(index % 3), index < 3 ? 1 : -1};
}

void TomlFields::axes(std::string_view key, std::optional<std::array<BodyAxis, 3>>& value) {
  const toml::node* node = node_->find(key, Presence::optional);
  if (node == nullptr) return;
  const std::string expected = "expected three different body axes, as in [\"+x\", \"-y\", \"+z\"]";
  const toml::array* list = node->as_array();
  if (list == nullptr || list->size() != 3)
    node_->fail(*node, key, fmt::format("{}; {}", list == nullptr ? Node::kind_of(*node) : "not three axes", expected));
  std::array<bool, 3> used{};
  value.emplace();
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string name = (*list)[i].value_or(std::string());
    const bool good = name.size() == 2 && (name[0] == '+' || name[0] == '-') && name[1] >= 'x' && name[1] <= 'z';
    if (!good || std::exchange(used[static_cast<std::size_t>(name[1] - 'x')], true)) node_->fail(*node, key, "is not such a list; " + expected);
    (*value)[i] = {name[1] - 'x', name[0] == '+' ? 1 : -1};
  }
}

void TomlFields::clock_zero(std::string_view key, std::int64_t& zero_ns, int exponent) {
  const toml::node* node = node_->find(key, Presence::optional);
  if (node == nullptr) return;
  node_->number(*node, key, any_number());
  const auto integer = node->value_exact<std::int64_t>();
  const std::string digits = integer ? fmt::format("{}", *integer) : node_->lexeme(*node);
  const ScaledInteger scaled = scaled_integer(digits.data(), digits.data() + digits.size(), exponent);
  if (scaled.status == ScaledInteger::Status::too_large) node_->fail(*node, key, "is more than 292 years; expected a time in the column's unit");
  if (scaled.status == ScaledInteger::Status::not_a_number || scaled.end != digits.data() + digits.size())
    node_->fail(*node, key, "is not a decimal number; expected one");
  zero_ns = scaled.value;
}

bool TomlFields::table(std::string_view key, Presence presence, const Body& body) {
  const toml::node* node = node_->find(key, presence);
  if (node == nullptr) return false;
  if (!node->is_table()) node_->fail(*node, key, Node::kind_of(*node) + "; expected a table");
  auto inner = std::make_unique<Node>();
  inner->file = node_->file;
  inner->text = node_->text;
  inner->table = node->as_table();
  inner->path = node_->name(key);
  TomlFields fields(std::move(inner));
  body(fields);
  fields.done();
  return true;
}

void TomlFields::tables(std::string_view key, const Body& body) { read_tables(key, body, true); }
void TomlFields::consecutive_tables(std::string_view key, const Body& body) { read_tables(key, body, false); }

void TomlFields::read_tables(std::string_view key, const Body& body, bool all) {
  const toml::node* node = node_->table->get(key);
  if (node == nullptr || !node->is_array()) {
    table(key, Presence::optional, body);
    return;
  }
  node_->asked.push_back(key);
  std::vector<std::string> problems;
  for (const toml::node& element : *node->as_array()) {
    if (!element.is_table()) node_->fail(element, key, Node::kind_of(element) + fmt::format("; expected tables [[{}]]", key));
    auto inner = std::make_unique<Node>();
    inner->file = node_->file;
    inner->text = node_->text;
    inner->table = element.as_table();
    inner->path = node_->name(key);
    TomlFields fields(std::move(inner));
    const auto read = [&] { body(fields), fields.done(); };
    all ? collect_problem(problems, read) : read();
  }
  throw_problems("", problems);
}

void TomlFields::check(bool good, std::string_view key, const std::string& message) const {
  if (good) return;
  if (!node_->missing.empty()) node_->fail_missing();
  const toml::node* node = node_->table->get(key);
  node_->fail(node != nullptr ? *node : *node_->table, key, message);
}

void TomlFields::done() const {
  for (const auto& [key, value] : *node_->table) {
    if (std::find(node_->asked.begin(), node_->asked.end(), key.str()) != node_->asked.end()) continue;
    throw Error(fmt::format("{}:{}: {}: is not a known key{}", node_->file, key.source().begin.line, node_->name(key.str()),
                            expected_name(key.str(), node_->asked)));
  }
  if (!node_->missing.empty()) node_->fail_missing();
}

std::string toml_as_json(std::string_view toml) {
  try {
    std::ostringstream text;
    text << toml::json_formatter{toml::parse(toml)} << "\n";
    return text.str();
  } catch (const toml::parse_error& e) {
    throw Error(excerpt(e.description(), longest_reason));
  }
}

}  // namespace imulab::text
