#include "imulab/formats/recording/arrays/npy_header.hpp"

#include "imulab/error.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <limits>
#include <optional>

namespace imulab::recording_io {
namespace {

[[noreturn]] void fail_npy(const std::string& place, const std::string& what) {
  throw Error(place + ": " + what + "; expected an array as NumPy writes it");
}

/// A value as Python writes it: text, a number, True and False, or several values.
struct PythonValue {
  std::string text;  // also of numbers and names
  std::vector<PythonValue> items;
  bool several = false;
};

class PythonReader {
 public:
  PythonReader(std::string_view text, const std::string& place) : text_(text), place_(place) {}

  PythonValue value(int depth = 0) {
    if (depth > 20) fail_npy(place_, "the head is nested too deep");
    const char c = peek();
    if (c == '(' || c == '[' || c == '{') return several(c == '(' ? ')' : c == '[' ? ']' : '}', depth);
    PythonValue result;
    if (c == '\'' || c == '"') {
      const std::size_t end = text_.find(c, at_ + 1);
      if (end == std::string_view::npos) fail_npy(place_, "the head has a text without an end");
      result.text = text_.substr(at_ + 1, end - at_ - 1);
      at_ = end + 1;
    } else {
      const std::size_t end = std::min(text_.find_first_of(",:)]} \n", at_), text_.size());
      result.text = text_.substr(at_, end - at_);
      if (result.text.empty()) fail_npy(place_, "the head has an empty value");
      at_ = end;
    }
    return result;
  }

 private:
  char peek() {
    while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\n')) ++at_;
    if (at_ >= text_.size()) fail_npy(place_, "the head ends too early");
    return text_[at_];
  }
  PythonValue several(char close, int depth) {
    PythonValue result;
    result.several = true;
    ++at_;
    while (peek() != close) {
      result.items.push_back(value(depth + 1));
      if (const char c = peek(); c == ',' || c == ':') ++at_;
    }
    ++at_;
    return result;
  }

  std::string_view text_;
  const std::string& place_;
  std::size_t at_ = 0;
};

std::size_t npy_number(std::string_view text, const std::string& place) {
  if (text.ends_with('L')) text.remove_suffix(1);  // of Python 2
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) fail_npy(place, fmt::format("{} is not a size", text));
  return number;
}

constexpr std::size_t most_counted = std::numeric_limits<std::ptrdiff_t>::max();  // that an index counts

std::size_t product(std::size_t a, std::size_t b, const std::string& place) {
  std::size_t result = 0;
  if (__builtin_mul_overflow(a, b, &result) || result > most_counted) fail_npy(place, "the array is larger than any file");
  return result;
}

std::size_t sum(std::size_t a, std::size_t b, const std::string& place) {
  if (a > most_counted - b) fail_npy(place, "the array is larger than any file");
  return a + b;
}

std::vector<std::size_t> npy_shape(const PythonValue& value, const std::string& place) {
  if (!value.several) return {npy_number(value.text, place)};
  std::vector<std::size_t> shape;
  for (const PythonValue& item : value.items) shape.push_back(npy_number(item.text, place));
  return shape;
}

/// The unit of times: "<M8[ns]".
std::string time_unit_of(std::string_view type) {
  for (const char* unit : {"s", "ms", "us", "ns"})
    if (type.ends_with(fmt::format("[{}]", unit))) return unit;
  return "";
}

/// The fields of an element, as its type says.
class ElementReader {
 public:
  explicit ElementReader(const std::string& place) : place_(place) {}

  void read(const PythonValue& type, const std::string& name) {
    if (type.several)
      read_fields(type, name);
    else
      read_plain(type.text, name);
  }

  std::vector<NumberField> fields;
  std::vector<ColumnDescription> columns;
  std::size_t bytes = 0;

 private:
  void read_plain(const std::string& type, const std::string& name) {
    if (type.size() < 2) fail_npy(place_, fmt::format("{} is not a type", type));
    const bool ordered = std::string_view("<>|=").find(type[0]) != std::string_view::npos;
    const std::string_view plain = std::string_view(type).substr(ordered ? 1 : 0);
    const std::string_view digits = plain.substr(1, plain.find('[') - 1);
    const std::size_t size = digits.empty() && plain[0] == 'O' ? 8 : npy_number(digits, place_);
    const char kind = plain[0] == 'b' ? 'u' : plain[0] == 'M' || plain[0] == 'm' ? 'i' : plain[0];
    const auto number = size < 10 ? number_type(fmt::format("{}{}", kind, size)) : std::nullopt;
    if (number) {
      fields.push_back({{number->kind, number->bytes, type[0] == '>'}, bytes});
      columns.push_back({name, time_unit_of(type)});
    }
    bytes = sum(bytes, product(size, plain[0] == 'U' ? 4 : 1, place_), place_);
    check_size();
  }

  void read_fields(const PythonValue& type, const std::string& before) {
    for (const PythonValue& item : type.items) {
      if (item.items.size() < 2) fail_npy(place_, "a field has no name and type");
      const PythonValue& named = item.items[0];  // or title and name
      const std::string& own = named.several && named.items.size() == 2 ? named.items[1].text : named.text;
      const std::string name = before.empty() ? own : before + "." + own;
      std::size_t count = 1;
      if (item.items.size() > 2)
        for (const std::size_t n : npy_shape(item.items[2], place_)) count = product(count, n, place_);
      if (count > 65536) fail_npy(place_, fmt::format("field {} has {} elements in a row", name, count));
      for (std::size_t i = 1; i <= count; ++i) read(item.items[1], item.items.size() > 2 ? fmt::format("{}.{}", name, i) : name);
    }
  }

  void check_size() const {
    if (bytes > (1 << 24) || fields.size() > 65536) fail_npy(place_, "a row is implausibly long");
  }

  const std::string& place_;
};

std::string type_text(const PythonValue& type) {
  if (!type.several) return type.text;
  return fmt::format("{} fields", type.items.size());
}

}  // namespace

std::size_t npy_head_size(std::string_view head) {
  if (head.size() < 12 || !head.starts_with("\x93NUMPY") || head[6] < 1 || head[6] > 3) return 0;
  return head[6] == 1 ? 10 + load<std::uint16_t>(head.data() + 8) : 12 + std::size_t{load<std::uint32_t>(head.data() + 8)};
}

NpyArray npy_array(std::string_view head, std::size_t available, const std::string& name, const std::string& place) {
  PythonReader reader(head.substr(head[6] == 1 ? 10 : 12), place);
  const PythonValue values = reader.value();
  const auto entry = [&](std::string_view key) -> const PythonValue& {
    for (std::size_t i = 0; i + 1 < values.items.size(); i += 2)
      if (values.items[i].text == key) return values.items[i + 1];
    fail_npy(place, fmt::format("the head has no {}", key));
  };
  NpyArray result;
  result.offset = head.size();
  result.type = type_text(entry("descr"));
  result.array.name = name;
  const bool structured = entry("descr").several;
  ElementReader element(place);
  element.read(entry("descr"), structured ? name : "");
  std::vector<std::size_t> shape = npy_shape(entry("shape"), place);
  result.bytes = std::max<std::size_t>(element.bytes, 1);
  for (const std::size_t n : shape) result.bytes = product(result.bytes, n, place);
  if (shape.size() > 1) std::erase(shape, std::size_t{1});
  if (shape.empty()) shape = {1};
  if (shape.size() > (structured ? 1 : 2) || element.fields.empty() || result.bytes == 0) return result;

  const ArrayShape table = table_shape(shape, entry("fortran_order").text == "False");
  if (available / element.bytes < table.columns) fail_npy(place, "has less than a row of numbers");
  result.array.rows = table.rows;
  result.by_column = table.by_column;
  result.stride = element.bytes * (table.by_column ? 1 : table.columns);
  if (structured) {
    result.fields = element.fields;
    result.array.columns = element.columns;
    return result;
  }
  result.array.columns = column_names(name, table.columns, element.columns.front().unit);
  for (std::size_t c = 0; c < table.columns; ++c)
    result.fields.push_back({element.fields.front().type, c * element.bytes * (table.by_column ? table.rows : 1)});
  return result;
}

}  // namespace imulab::recording_io
