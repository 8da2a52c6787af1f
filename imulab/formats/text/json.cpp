#include "imulab/formats/text/json.hpp"

#include "imulab/core/nearest_name.hpp"
#include "imulab/error.hpp"
#include "imulab/formats/text/json_fields.hpp"
#include "imulab/formats/text/printable.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <unordered_map>

namespace imulab {
namespace {

using JsonList = std::vector<JsonValue>;

bool is_structured(const JsonValue& value) { return std::holds_alternative<JsonList>(value.is) || std::holds_alternative<JsonFields>(value.is); }

/// The name of a file may be any bytes: those that are not UTF-8 become U+FFFD.
std::string dumped(const nlohmann::json& value) { return with_escapes(value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)); }

std::string plain_text(const JsonValue& value) {
  return std::visit(
      [](const auto& own) {
        if constexpr (std::is_same_v<std::decay_t<decltype(own)>, JsonList> || std::is_same_v<std::decay_t<decltype(own)>, JsonFields>)
          return std::string();
        else
          return dumped(own);
      },
      value.is);
}

bool on_one_line(const JsonList& list, JsonLayout layout) {
  constexpr std::size_t many = 16;
  if (layout == JsonLayout::rows_on_lines) return std::none_of(list.begin(), list.end(), is_structured);
  const auto is_number = [](const JsonValue& v) {
    return !is_structured(v) && !std::holds_alternative<bool>(v.is) && !std::holds_alternative<std::string>(v.is);
  };
  return layout == JsonLayout::one_line ||
         (layout == JsonLayout::long_lists && list.size() >= many && std::all_of(list.begin(), list.end(), is_number));
}

void write(std::string& out, const JsonValue& value, JsonLayout layout, std::size_t indent);

/// Items between brackets: on one line, or each on its own.
template <class Items, class Write>
void write_items(std::string& out, const char* brackets, const Items& items, bool one_line, JsonLayout layout, std::size_t indent, Write write_item) {
  const auto line = [&](std::size_t blanks) { return one_line || items.empty() ? "" : "\n" + std::string(blanks, ' '); };
  const std::string separator = !one_line ? "," + line(indent + 2) : layout == JsonLayout::rows_on_lines ? ", " : ",";
  out += brackets[0] + line(indent + 2);
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (i > 0) out += separator;
    write_item(items[i]);
  }
  out += line(indent) + brackets[1];
}

void write(std::string& out, const JsonValue& value, JsonLayout layout, std::size_t indent) {
  if (const auto* list = std::get_if<JsonList>(&value.is)) {
    write_items(out, "[]", *list, on_one_line(*list, layout), layout, indent, [&](const JsonValue& v) { write(out, v, layout, indent + 2); });
  } else if (const auto* object = std::get_if<JsonFields>(&value.is)) {
    const bool one_line = layout == JsonLayout::one_line;
    write_items(out, "{}", object->fields, one_line, layout, indent, [&](const auto& field) {
      out += dumped(field.first) + (one_line ? ":" : ": ");
      write(out, field.second, layout, indent + 2);
    });
  } else {
    out += plain_text(value);
  }
}

}  // namespace

std::string json_text(const JsonValue& value, JsonLayout layout) {
  std::string out;
  write(out, value, layout, 0);
  return out + "\n";
}

}  // namespace imulab

namespace imulab::json_io {
namespace {

/// The parser's events as a value.
class Builder : public nlohmann::json_sax<nlohmann::json> {
 public:
  Builder(const std::string& file, const std::string& what, Keys keys) : file_(file), what_(what), keys_(keys) {}

  bool null() override { return put(nullptr); }
  bool boolean(bool value) override { return put(value); }
  bool number_integer(number_integer_t value) override { return put(value); }
  bool number_unsigned(number_unsigned_t value) override { return put(value); }
  bool number_float(number_float_t value, const string_t&) override { return put(value); }
  bool string(string_t& value) override { return put(std::move(value)); }
  bool binary(binary_t&) override { return false; }
  bool start_object(std::size_t) override { return open(JsonFields()); }
  bool start_array(std::size_t) override { return open(std::vector<JsonValue>()); }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }
  bool key(string_t& name) override {
    constexpr std::size_t most_keys = 100'000;
    auto& fields = std::get<JsonFields>(open_.back()->is).fields;
    const auto [known, added] = places_.back().emplace(name, fields.size());
    if (!added && keys_ == Keys::once) throw Error(file_ + ": " + excerpt(name) + ": is given twice; expected each key once");
    if (fields.size() >= most_keys) throw Error(fmt::format("{}: an object has more than {} keys; expected {}", file_, most_keys, what_));
    if (added) fields.emplace_back(std::move(name), JsonValue());
    place_ = &fields[known->second].second;
    return true;
  }
  bool parse_error(std::size_t, const std::string&, const nlohmann::detail::exception& e) override {
    if (const auto* at = dynamic_cast<const nlohmann::json::parse_error*>(&e)) throw *at;
    throw Error(fmt::format("{}: not {}: {}", file_, what_, excerpt(e.what(), 200)));
  }

  JsonValue root;

 private:
  bool put(JsonValue value) {
    place(std::move(value));
    return true;
  }
  JsonValue& place(JsonValue value) {
    if (open_.empty()) return root = std::move(value);
    if (auto* list = std::get_if<std::vector<JsonValue>>(&open_.back()->is)) return list->emplace_back(std::move(value));
    return *place_ = std::move(value);
  }
  bool open(JsonValue value) {
    constexpr std::size_t deepest = 100;
    if (open_.size() > deepest) throw Error(fmt::format("{}: nested too deeply; expected {}", file_, what_));
    open_.push_back(&place(std::move(value)));
    places_.emplace_back();
    return true;
  }
  bool close() {
    open_.pop_back();
    places_.pop_back();
    return true;
  }

  const std::string &file_, &what_;
  Keys keys_;
  std::vector<JsonValue*> open_;                                      // a list grows only while its last element is closed
  std::vector<std::unordered_map<std::string, std::size_t>> places_;  // of each that is open, where its keys are
  JsonValue* place_ = nullptr;                                        // of the key that was read last
};

}  // namespace

JsonValue parse_json(std::string_view text, const std::string& file, const std::string& what, Keys keys) {
  Builder builder(file, what, keys);
  try {
    nlohmann::json::sax_parse(text, &builder);
  } catch (const nlohmann::json::parse_error& e) {
    const std::size_t first = text.find_first_not_of(" \t\r\n");
    if (first != std::string_view::npos && text[first] != '{' && text[first] != '[')
      throw NotJson(fmt::format("{}: is not JSON, but perhaps a recording; expected {}", file, what));
    const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(std::min(e.byte, text.size())), '\n');
    throw Error(fmt::format("{}:{}: not JSON; expected {}: {}", file, line, what,
                            excerpt(std::string_view(e.what()).substr(std::string_view(e.what()).find("] ") + 2), 200)));
  }
  return std::move(builder.root);
}

void Field::fail(const std::string& text) const { throw Error(file_ + ": " + (path_.empty() ? "" : excerpt(path_, 200) + ": ") + text); }

void Field::expected(const std::string& what) const {
  if (const auto* list = std::get_if<std::vector<JsonValue>>(&value_.is))
    fail("expected " + what + ", found " + (list->empty() ? "[]" : "array"));  // a list of a million numbers is not written to be cut
  if (const auto* object = std::get_if<JsonFields>(&value_.is)) fail("expected " + what + ", found " + (object->fields.empty() ? "{}" : "object"));
  fail("expected " + what + ", found " + excerpt(plain_text(value_)));
}

std::vector<std::string> Field::keys() const {
  const auto* object = std::get_if<JsonFields>(&value_.is);
  if (object == nullptr) expected("an object");
  std::vector<std::string> out;
  for (const auto& field : object->fields) out.push_back(field.first);
  return out;
}

const JsonValue* Field::find(std::string_view key) const {
  const auto* object = std::get_if<JsonFields>(&value_.is);
  if (object == nullptr) return nullptr;
  const auto at = std::find_if(object->fields.begin(), object->fields.end(), [&](const auto& field) { return field.first == key; });
  return at == object->fields.end() ? nullptr : &at->second;
}

bool Field::has(std::string_view key) const { return find(key) != nullptr; }

Field Field::operator[](std::string_view key) const {
  if (!std::holds_alternative<JsonFields>(value_.is)) expected("an object");
  const JsonValue* value = find(key);
  Field field(value != nullptr ? *value : value_, file_, path_ + (path_.empty() ? "" : ".") + std::string(key));
  if (value == nullptr) field.fail("is missing");
  return field;
}

std::size_t Field::size() const {
  const auto* list = std::get_if<std::vector<JsonValue>>(&value_.is);
  if (list == nullptr) expected("a list");
  return list->size();
}

Field Field::item(std::size_t i, std::size_t count, const char* things) const {
  const auto* list = std::get_if<std::vector<JsonValue>>(&value_.is);
  if (list == nullptr || list->size() != count) fail(fmt::format("expected {} {}", count, things));
  return {(*list)[i], file_, fmt::format("{}[{}]", path_, i)};
}

double Field::number() const {
  if (const auto* number = std::get_if<double>(&value_.is)) return *number;
  if (const auto* number = std::get_if<std::int64_t>(&value_.is)) return static_cast<double>(*number);
  if (const auto* number = std::get_if<std::uint64_t>(&value_.is)) return static_cast<double>(*number);
  expected("a number");
}

int Field::whole_number() const {
  if (!std::holds_alternative<std::int64_t>(value_.is) && !std::holds_alternative<std::uint64_t>(value_.is)) expected("a whole number");
  if (!(std::abs(number()) <= std::numeric_limits<int>::max())) expected("a whole number that 32 bits hold");
  return static_cast<int>(number());
}

std::uint64_t Field::size_in_bytes() const {
  if (const auto* number = std::get_if<std::uint64_t>(&value_.is)) return *number;
  expected("a whole number from 0 on");
}

bool Field::truth() const {
  if (const auto* truth = std::get_if<bool>(&value_.is)) return *truth;
  expected("true or false");
}

std::string Field::text() const {
  if (const auto* text = std::get_if<std::string>(&value_.is)) return *text;
  expected("a text");
}

std::vector<std::string> Field::texts() const {
  return list([](const Field& f) { return f.text(); });
}

std::vector<std::string> Field::texts(std::string_view key) const { return has(key) ? (*this)[key].texts() : std::vector<std::string>(); }

void Problems::add(const std::string& text) {
  constexpr std::size_t most = 20;
  if (std::find(texts_.begin(), texts_.end(), text) != texts_.end()) return;
  if (texts_.size() < most)
    texts_.push_back(text);
  else
    ++more_;
}

void Problems::expect_none() const {
  if (texts_.empty()) return;
  throw Error(fmt::format("{}{}", fmt::join(texts_, "\n"), more_ > 0 ? fmt::format("\nand {} more", more_) : ""));
}

void Problems::expect_known_keys(const Field& field, const std::vector<std::string_view>& known, bool others_allowed) {
  std::vector<std::string_view> missing;
  for (const std::string_view key : known)
    if (!field.has(key)) missing.push_back(key);
  constexpr std::size_t most_unknown = 1000;  // each is compared with all known ones
  std::size_t unknown = 0;
  for (const std::string& key : field.keys()) {
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    if (++unknown > most_unknown) {
      none_in([&] { field.fail(fmt::format("has more than {} unknown keys; expected {}", most_unknown, text::listed(known))); });
      break;
    }
    const std::string_view meant = nearest_name(key, missing);
    const auto small = [](std::string_view name) { return std::tolower(static_cast<unsigned char>(name[0])); };
    if (others_allowed && (meant.empty() || small(meant) != small(key))) continue;
    none_in([&] {
      field[key].fail(
          fmt::format("is unknown; {}", meant.empty() ? "expected one of " + text::listed(known) : fmt::format("did you mean {}?", meant)));
    });
  }
}

double with_digits(double value, int digits) {
  if (digits == 0 || value == 0 || !std::isfinite(value)) return value;
  const double size = std::pow(10.0, digits - 1 - static_cast<int>(std::floor(std::log10(std::abs(value)))));
  return std::isfinite(size) && size > 0 ? std::round(value * size) / size : value;
}

CoefficientIndex coefficient_of(const Field& parent, const std::string& key) {
  try {
    return coefficient_index(key);
  } catch (const Error& e) {
    parent.fail(e.what());
  }
}

double read_number(const Field& at, const fields::How& how) {
  if (!at.is_null() || how.null == fields::Null::none) return at.number() * how.size;
  if (how.null == fields::Null::empty) return 0;
  return how.null == fields::Null::nan ? at.number_or_nan() : at.number_or_infinity();
}

}  // namespace imulab::json_io
