#include "imulab/formats/recording/text/json_rows.hpp"

#include "imulab/error.hpp"
#include "imulab/formats/recording/text/json_scan.hpp"
#include "imulab/formats/text/printable.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

namespace imulab::recording_io {
namespace {

constexpr std::size_t most_names = 4096, elements_looked_at = 200;

bool begins_row(std::string_view text, std::size_t place) { return place < text.size() && (text[place] == '[' || text[place] == '{'); }

std::size_t count_scalars(std::string_view value) {
  std::size_t count = 0;
  return for_json_scalars(value, [&](std::string_view, const JsonScalar&) { ++count; }) ? count : 0;
}

/// The longest array of rows inside an object, three levels deep; empty where there is none.
std::string_view array_of_rows(std::string_view object, int depth = 0) {
  constexpr int deepest = 3;
  std::string_view longest;
  for_json_members(object, [&](std::string_view, std::string_view value) {
    const bool rows = value.starts_with('[') && begins_row(value, skip_json_blanks(value, 1));
    const std::string_view found = rows ? value : value.starts_with('{') && depth < deepest ? array_of_rows(value, depth + 1) : std::string_view{};
    if (found.size() > longest.size()) longest = found;
  });
  return longest;
}

}  // namespace

JsonRows::JsonRows(std::string file, std::string_view text, bool complete) : file_(std::move(file)) {
  const std::size_t place = skip_json_blanks(text, 0);
  if (place == text.size()) return;
  if (text[place] == '[') look_at_array(text, place, complete);
  if (text[place] == '{') look_at_object(text, place, complete);
}

void JsonRows::look_at_array(std::string_view text, std::size_t place, bool complete) {
  const std::size_t inside = skip_json_blanks(text, place + 1);
  const bool nested = begins_row(text, inside);
  if (inside == text.size() && !complete) shape_ = Shape::more;
  const JsonExtent first = skip_json(text, nested ? inside : place);
  if (first.how == JsonEnd::cut && !complete) shape_ = Shape::more;
  if (first.how != JsonEnd::whole) return;
  if (nested) {
    shape_ = Shape::array;
    skip_ = place + 1;
    return find_names(text.substr(inside));
  }
  const std::size_t next = skip_json_blanks(text, first.end);
  if (next == text.size() && !complete) shape_ = Shape::more;
  if (next < text.size() && text[next] == '[' && count_scalars(text.substr(place, first.end - place)) > 1) shape_ = Shape::lines;
}

void JsonRows::look_at_object(std::string_view text, std::size_t place, bool complete) {
  const JsonExtent first = skip_json(text, place);
  if (first.how == JsonEnd::cut && !complete) shape_ = Shape::more;
  if (first.how != JsonEnd::whole) return;
  const std::size_t next = skip_json_blanks(text, first.end);
  if (next < text.size()) {
    if (text[next] == '{' || text[next] == ',') shape_ = Shape::lines, find_names(text.substr(place));
    return;
  }
  if (!complete) {
    shape_ = Shape::more;
    return;
  }
  const std::string_view object = text.substr(place, first.end - place), rows = array_of_rows(object);
  if (!rows.empty()) {
    shape_ = Shape::array;
    skip_ = static_cast<std::size_t>(rows.data() - text.data()) + 1;
    return find_names(rows.substr(1));
  }
  if (find_columns(object)) shape_ = Shape::columns;
}

/// Two members or more that are arrays (or objects) of as many scalars.
bool JsonRows::find_columns(std::string_view object) {
  std::size_t rows = 0;
  bool even = true;
  for_json_members(object, [&](std::string_view key, std::string_view value) {
    if (!begins_row(value, 0) || begins_row(value, skip_json_blanks(value, 1))) return;
    const std::size_t count = count_scalars(value);
    if (count < 2) return;
    even = even && (rows == 0 || rows == count);
    rows = count;
    names_.emplace_back(key);
  });
  if (names_.size() < 2) return names_.clear(), false;
  if (!even) throw Error(fmt::format("{}: its arrays have different lengths; expected columns of one length", file_));
  return true;
}

/// The keys of the first elements, in their order.
void JsonRows::find_names(std::string_view elements) {
  std::size_t at = 0;
  for (std::size_t n = 0; n < elements_looked_at; ++n) {
    while (at < elements.size() && elements[at] == ',') ++at;
    at = skip_json_blanks(elements, at);
    const JsonExtent extent = skip_json(elements, at);
    if (extent.how != JsonEnd::whole) return;
    const std::string_view element = elements.substr(at, extent.end - at);
    at = skip_json_blanks(elements, extent.end);
    if (element.front() != '{') continue;
    for_json_scalars(element, [&](std::string_view path, const JsonScalar&) {
      if (names_.size() < most_names && places_.emplace(path, names_.size()).second) names_.emplace_back(path);
    });
  }
}

/// A row in the order of the columns.
void JsonRows::add_row(std::string_view element, std::string& out) {
  const std::size_t begin = out.size();
  const bool named = element.front() == '{' && !names_.empty();
  std::vector<JsonScalar> values(named ? names_.size() : 0);
  std::vector<JsonField> fields;
  std::size_t next = 0;
  const bool whole = for_json_scalars(element, [&](std::string_view path, const JsonScalar& value) {
    if (!named) {
      fields.push_back({value, values.size()});
      return values.push_back(value);
    }
    if (next == names_.size() || names_[next] != path) {
      const auto found = places_.find(std::string(path));
      if (found == places_.end()) {
        if (unknown_.empty()) unknown_ = path, unknown_at_ = elements_ + 1;
        return fields.push_back({value, std::nullopt});
      }
      next = found->second;
    }
    fields.push_back({value, next});
    values[next++] = value;
  });
  ++elements_;
  if (!whole || !begins_row(element, 0)) {
    out.resize(begin);
    if (counts_elements()) throw Error(fmt::format("{}: element {}: is no row; expected an array or an object of numbers", file_, elements_));
    out.append(element);
    std::replace(out.begin() + static_cast<std::ptrdiff_t>(begin), out.end(), '\n', ' ');
    return;
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (i > 0) out.push_back(',');
    append_json_field(values[i], out);
  }
  remember_pattern(element, fields);
}

/// Of rows that lie on one line; those of a few kinds may alternate, as a gyro's and an accelerometer's do.
void JsonRows::remember_pattern(std::string_view element, const std::vector<JsonField>& fields) {
  constexpr std::size_t most = 4;
  if (element.find('\n') != std::string_view::npos) return;
  const std::size_t columns = element.front() == '{' && !names_.empty() ? names_.size() : fields.size();
  auto pattern = JsonPattern::of(element, fields, columns);
  if (!pattern) return;
  if (patterns_.size() < most) return patterns_.push_back(*std::move(pattern));
  patterns_[replaced_++ % most] = *std::move(pattern);
}

/// Appends a row that begins a text, if it is written as one before; returns its length, else 0.
std::size_t JsonRows::add_known_row(std::string_view text, std::string& out) {
  for (const JsonPattern& pattern : patterns_)
    if (const std::size_t length = pattern.add_row(text, out)) return ++elements_, length;
  return 0;
}

/// A line that is no JSON stays, for the reader of rows to judge; in an array it is an error. Returns its end.
std::size_t JsonRows::add_other_text(std::string_view text, std::size_t at, std::string& out) {
  if (counts_elements()) throw Error(fmt::format("{}: element {}: is no JSON; expected a row of numbers", file_, elements_ + 1));
  const std::size_t end = std::min(text.find('\n', at), text.size());
  out.append(text.substr(at, end - at));
  row_on_line_ = true;
  return end;
}

/// Appends the elements of a text; returns where one begins that is not complete.
std::size_t JsonRows::add_elements(std::string_view text, bool last, std::string& out) {
  std::size_t at = 0;
  while (at < text.size() && !ended_) {
    const char c = text[at];
    if (c == '\n' && !counts_elements()) {
      if (owed_ > 0) {
        --owed_;
      } else {
        out.push_back('\n');
        row_on_line_ = false;
      }
    }
    if (c == ' ' || c == '\n' || c == '\r' || c == '\t' || c == ',') {
      ++at;
      continue;
    }
    if (c == ']' && counts_elements()) {
      ended_ = true;
      break;
    }
    if (!row_on_line_)
      if (const std::size_t length = add_known_row(text.substr(at), out)) {
        at += length;
        row_on_line_ = !counts_elements();
        if (counts_elements()) out.push_back('\n');
        continue;
      }
    const JsonExtent extent = begins_row(text, at) ? skip_json(text, at) : JsonExtent{};
    if (extent.how == JsonEnd::cut && !last) return at;
    if (extent.how == JsonEnd::cut && counts_elements()) return cut_ = true, text.size();
    if (extent.how != JsonEnd::whole) {
      if (!last && !counts_elements() && text.find('\n', at) == std::string_view::npos) return at;  // the rest of the line has to come
      at = add_other_text(text, at, out);
      continue;
    }
    const std::string_view element = text.substr(at, extent.end - at);
    if (row_on_line_) out.push_back('\n'), ++owed_;
    if (!counts_elements()) out.append(static_cast<std::size_t>(std::count(element.begin(), element.end(), '\n')), '\n');
    add_row(element, out);
    row_on_line_ = !counts_elements();
    if (counts_elements()) out.push_back('\n');
    at = extent.end;
  }
  return at;
}

void JsonRows::add_columns(std::string_view text, std::string& out) {
  std::vector<std::vector<JsonScalar>> columns;
  for_json_members(text, [&](std::string_view key, std::string_view value) {
    if (columns.size() == names_.size() || key != names_[columns.size()]) return;
    std::vector<JsonScalar>& column = columns.emplace_back();
    for_json_scalars(value, [&](std::string_view, const JsonScalar& scalar) { column.push_back(scalar); });
  });
  const auto shorter = [](const auto& a, const auto& b) { return a.size() < b.size(); };
  const auto [least, most] = std::minmax_element(columns.begin(), columns.end(), shorter);
  if (columns.size() != names_.size() || least->size() != most->size())
    throw Error(fmt::format("{}: its arrays are not {} of one length; expected a number of each for every row", file_, names_.size()));
  for (std::size_t row = 0; row < most->size(); ++row)
    for (std::size_t c = 0; c < columns.size(); ++c) {
      append_json_field(columns[c][row], out);
      out.push_back(c + 1 < columns.size() ? ',' : '\n');
    }
}

void JsonRows::add(std::string_view text, bool last, std::string& out) {
  constexpr std::size_t longest_element = std::size_t{1} << 20;  // bytes, of a stream
  if (shape_ == Shape::columns) {
    rest_ += text;
    if (last) add_columns(rest_, out);
    return;
  }
  out.reserve(out.size() + text.size());
  const std::size_t skipped = std::min(skip_, text.size());
  text.remove_prefix(skipped), skip_ -= skipped;
  std::string joined;
  if (!rest_.empty()) joined = rest_ + std::string(text), text = joined;
  const std::size_t end = add_elements(text, last, out);
  if (text.size() - std::min(end, text.size()) > longest_element)
    throw Error(fmt::format("{}: element {}: has more than {} bytes; expected a row of numbers", file_, elements_ + 1, longest_element));
  rest_ = ended_ ? std::string() : std::string(text.substr(end));
}

std::vector<std::string> JsonRows::notes() const {
  std::vector<std::string> notes;
  if (cut_) notes.push_back(fmt::format("{}: ends inside element {}, which is left out", file_, elements_ + 1));
  if (!unknown_.empty())
    notes.push_back(
        fmt::format("{}: the key {} is not in the first elements, and is left out from element {} on", file_, excerpt(unknown_), unknown_at_));
  return notes;
}

}  // namespace imulab::recording_io
