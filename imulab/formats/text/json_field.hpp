// Reading JSON with messages that name file, path and what was expected. Slow to compile: for the sources that read JSON, no others.
#pragma once

#include "imulab/core/error.hpp"
#include "imulab/formats/text/json_dump.hpp"
#include "imulab/formats/text/printable.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace imulab::json_text {

using Json = nlohmann::ordered_json;

/// A value in a JSON file and the path that leads to it, which every message names.
class Field {
 public:
  Field(const Json& value, std::string file, std::string path) : value_(value), file_(std::move(file)), path_(std::move(path)) {}

  [[noreturn]] void fail(const std::string& text) const { throw Error(file_ + ": " + (path_.empty() ? "" : excerpt(path_, 200) + ": ") + text); }
  [[noreturn]] void expected(const std::string& what) const {
    const bool structured = value_.is_structured() && !value_.empty();  // a list of a million numbers is not written to be cut
    fail("expected " + what + ", found " + (structured ? value_.type_name() : excerpt(dump_json(value_, -1))));
  }

  /// Of an object, in the file's order.
  std::vector<std::string> keys() const {
    if (!value_.is_object()) expected("an object");
    std::vector<std::string> out;
    for (const auto& item : value_.items()) out.push_back(item.key());
    return out;
  }
  bool is_null() const { return value_.is_null(); }
  bool has(std::string_view key) const { return value_.is_object() && value_.contains(key); }
  Field operator[](std::string_view key) const {
    if (!value_.is_object()) expected("an object");
    Field field(value_.contains(key) ? value_.at(std::string(key)) : value_, file_, path_ + (path_.empty() ? "" : ".") + std::string(key));
    if (!value_.contains(key)) field.fail("is missing");
    return field;
  }
  std::size_t size() const {
    if (!value_.is_array()) expected("a list");
    return value_.size();
  }
  /// Element i of a list of `count` things.
  Field item(std::size_t i, std::size_t count, const char* things) const {
    if (!value_.is_array() || value_.size() != count) fail(fmt::format("expected {} {}", count, things));
    return {value_[i], file_, fmt::format("{}[{}]", path_, i)};
  }

  double number() const {
    if (!value_.is_number()) expected("a number");
    return value_.get<double>();
  }
  double number_or_nan() const { return is_null() ? std::numeric_limits<double>::quiet_NaN() : number(); }
  int whole_number() const {
    if (!value_.is_number_integer()) expected("a whole number");
    constexpr double largest = std::numeric_limits<int>::max();
    if (!(std::abs(value_.get<double>()) <= largest)) expected("a whole number that 32 bits hold");
    return value_.get<int>();
  }
  std::uint64_t size_in_bytes() const {
    if (!value_.is_number_unsigned()) expected("a whole number from 0 on");
    return value_.get<std::uint64_t>();
  }
  bool truth() const {
    if (!value_.is_boolean()) expected("true or false");
    return value_.get<bool>();
  }
  std::string text() const {
    if (!value_.is_string()) expected("a text");
    return value_.get<std::string>();
  }
  std::string text_or_empty(std::string_view key) const { return has(key) && !(*this)[key].is_null() ? (*this)[key].text() : ""; }
  double number_or_infinity() const { return is_null() ? std::numeric_limits<double>::infinity() : number(); }
  template <class Read>
  auto list(Read read) const {
    std::vector<decltype(read(*this))> out;
    for (std::size_t i = 0, n = size(); i < n; ++i) out.push_back(read(item(i, n, "elements")));
    return out;
  }
  /// An absent list is empty.
  template <class Read>
  auto list(std::string_view key, Read read) const {
    return has(key) ? (*this)[key].list(read) : std::vector<decltype(read(*this))>{};
  }
  std::vector<std::string> texts() const {
    return list([](const Field& f) { return f.text(); });
  }
  std::vector<std::string> texts(std::string_view key) const {
    return list(key, [](const Field& f) { return f.text(); });
  }
  std::map<std::string, std::string> text_map(std::string_view key) const {
    std::map<std::string, std::string> out;
    if (!has(key)) return out;
    const Field field = (*this)[key];
    if (!field.value_.is_object()) field.expected("an object");
    for (const auto& item : field.value_.items()) out[item.key()] = field[item.key()].text();
    return out;
  }

 private:
  const Json& value_;
  std::string file_, path_;
};

/// What is wrong with a file, part after part: all of it is one Error, a line each.
class Problems {
 public:
  /// Whether `read` found none in its part.
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
  void expect_none() const {
    if (texts_.empty()) return;
    throw Error(fmt::format("{}{}", fmt::join(texts_, "\n"), more_ > 0 ? fmt::format("\nand {} more", more_) : ""));
  }

 private:
  void add(const std::string& text) {
    constexpr std::size_t most = 20;
    if (std::find(texts_.begin(), texts_.end(), text) != texts_.end()) return;
    texts_.size() < most ? texts_.push_back(text) : void(++more_);
  }

  std::vector<std::string> texts_;
  std::size_t more_ = 0;
};

/// A key that is not of the format is refused; where others are allowed only one that is nearly, from its first letter on, a key that is missing: it
/// would be left out without a word.
inline void expect_known_keys(const Field& field, const std::vector<std::string_view>& known, bool others_allowed, Problems& problems) {
  std::vector<std::string_view> missing;
  for (const std::string_view key : known)
    if (!field.has(key)) missing.push_back(key);
  for (const std::string& key : field.keys()) {
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    const std::string_view meant = text::nearest_name(key, missing);
    const auto small = [](std::string_view name) { return std::tolower(static_cast<unsigned char>(name[0])); };
    if (others_allowed && (meant.empty() || small(meant) != small(key))) continue;
    problems.none_in(
        [&] { field[key].fail(fmt::format("is unknown; expected {}", meant.empty() ? "one of " + text::listed(known) : std::string(meant))); });
  }
}

/// Throws Error where the text is no JSON, or nested deeper than any result; `what` is expected: "a calibration".
inline Json parse_json(std::string_view text, const std::string& file, const std::string& what) {
  constexpr int deepest = 100;
  const auto shallow = [&](int depth, Json::parse_event_t, Json&) {
    if (depth > deepest) throw Error(fmt::format("{}: nested too deeply; expected {}", file, what));
    return true;
  };
  try {
    return Json::parse(text, shallow);
  } catch (const Json::parse_error& e) {
    const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(std::min(e.byte, text.size())), '\n');
    throw Error(fmt::format("{}:{}: not JSON; expected {}: {}", file, line, what,
                            excerpt(std::string_view(e.what()).substr(std::string_view(e.what()).find("] ") + 2), 200)));
  } catch (const Json::exception& e) {
    throw Error(fmt::format("{}: not {}: {}", file, what, excerpt(e.what(), 200)));
  }
}

}  // namespace imulab::json_text
