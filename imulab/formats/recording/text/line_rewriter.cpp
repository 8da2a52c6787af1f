#include "imulab/formats/recording/text/line_rewriter.hpp"

#include "imulab/formats/recording/text/number_form.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace imulab::recording_io {
namespace {

bool is_a_digit(char c) { return c >= '0' && c <= '9'; }

/// Three digits and no more: what stands behind a sign between thousands.
bool is_a_thousand(std::string_view text) {
  return text.size() >= 3 && std::all_of(text.begin(), text.begin() + 3, is_a_digit) && (text.size() == 3 || !is_a_digit(text[3]));
}

/// Appends a number with a point as decimal mark and nothing between thousands; false, with nothing appended, for a number of another convention.
bool append_number(std::string_view field, char decimal, char thousands, std::string& out) {
  const std::size_t begin = out.size();
  bool fraction = false;
  for (std::size_t i = 0; i < field.size();) {
    const char c = field[i];
    std::size_t step = 1;
    char kind = c;
    if (c == decimal && !fraction) {
      out.push_back('.');
      fraction = true;
    } else if (thousands != 0 && (c == thousands || (group_sign(field.substr(i), kind) > 0 && kind == thousands))) {
      step = c == thousands ? 1 : group_sign(field.substr(i), kind);
      if (fraction || i == 0 || !is_a_thousand(field.substr(i + step))) return out.resize(begin), false;
    } else if (c == ',' || (c == '.' && decimal != '.')) {
      return out.resize(begin), false;
    } else {
      out.push_back(c);
    }
    i += step;
  }
  return true;
}

/// Appends the first line, if it is nothing but numbers without signs between thousands, as nearly all lines are, and returns its length; else 0.
std::size_t append_numbers(std::string_view lines, const Dialect& dialect, std::string& out) {
  constexpr std::size_t longest = 4096;
  std::array<char, longest> line;
  char* to = line.data();
  const std::size_t size = std::min(lines.size(), longest);
  bool at_first = true, marked = false, quoted = false;  // of the field
  std::size_t i = 0;
  for (; i < size && lines[i] != '\n'; ++i) {
    const char c = lines[i];
    if (is_a_digit(c)) {
      *to++ = c, at_first = false;
    } else if (c == dialect.delimiter && !quoted) {
      *to++ = c, at_first = true, marked = false;
    } else if (c == dialect.decimal && !marked) {
      *to++ = '.', at_first = false, marked = true;
    } else if (c == '-' || c == '+' || (!at_first && (c == 'e' || c == 'E'))) {
      *to++ = c, at_first = false;
    } else if (c == '"' && dialect.quotes && at_first && !quoted) {
      quoted = true;
    } else if (c == '"' && quoted && (i + 1 == lines.size() || lines[i + 1] == dialect.delimiter || lines[i + 1] == '\r' || lines[i + 1] == '\n')) {
      quoted = false;
    } else if (c == '\r' && (i + 1 == lines.size() || lines[i + 1] == '\n')) {
      continue;
    } else {
      return 0;
    }
  }
  if (quoted || (i == longest && i < lines.size())) return 0;
  out.append(line.data(), to);
  return i;
}

}  // namespace

bool LineRewriter::is_independent() const {
  return std::find(dialect_.uses.begin(), dialect_.uses.end(), FieldUse::time_of_day) == dialect_.uses.end();
}

/// A date, a time of day, or text in their place as it is.
void LineRewriter::add_moment(std::string_view field, FieldUse use, std::string_view line, std::string& out) {
  using text::moment_of;
  if (use == FieldUse::time_after) {
    const text::Moment date = moment_of(date_, dialect_.order), time = moment_of(field);
    const bool both = date.has_date && time.has_time;
    return both ? text::append_seconds(out, date.seconds + time.seconds, time.fraction) : void(out.append(field));
  }
  text::Moment moment = moment_of(field, dialect_.order);
  if (use == FieldUse::date_before || use == FieldUse::joined_date) {
    date_ = field;
    const std::vector<FieldText> next = moment ? split_fields(line, dialect_.delimiter) : std::vector<FieldText>{};
    const text::Moment time = next.empty() ? text::Moment{} : moment_of(next.front().text);
    if (!time.has_time) return void(out.append(field));
    moment.seconds += time.seconds, moment.fraction = time.fraction;
    joined_ = use == FieldUse::joined_date;
    return text::append_seconds(out, moment.seconds, moment.fraction);
  }
  if (!moment.has_time || (use == FieldUse::date && !moment.has_date)) return void(out.append(field));
  if (use == FieldUse::time_of_day) {
    constexpr std::int64_t whole_day = 86400;
    if (before_ > moment.seconds + whole_day / 2) day_ += whole_day;
    before_ = moment.seconds;
    moment.seconds += day_;
  }
  text::append_seconds(out, moment.seconds, moment.fraction);
}

/// `line`: what follows the field.
void LineRewriter::add_field(std::string_view field, std::size_t index, std::string_view line, std::string& out) {
  const FieldUse use = dialect_.use(index);
  if (use != FieldUse::number_or_text && use != FieldUse::sensor) return add_moment(field, use, line, out);
  const char first = field.empty() ? 'x' : field.front();
  const bool may_be_number = is_a_digit(first) || first == '-' || first == '+' || first == '.' || first == ',';
  if (may_be_number && append_number(field, dialect_.decimal, dialect_.thousands, out)) return;
  if (may_be_number) out.push_back('"');
  const std::size_t begin = out.size();
  out.append(field);
  if (field.find(dialect_.delimiter) != std::string_view::npos)
    std::replace(out.begin() + static_cast<std::ptrdiff_t>(begin), out.end(), dialect_.delimiter, dialect_.delimiter == ' ' ? '_' : ' ');
  if (may_be_number) out.push_back('"');
}

LineRewriter::Taken LineRewriter::take_field(std::string_view& line) const {
  Taken taken;
  const bool blanks = dialect_.delimiter == ' ';
  bool quoted = false;
  if (dialect_.quotes && line.starts_with('"')) {
    const FieldText first = split_fields(line, dialect_.delimiter).front();
    quoted = first.quoted;
    if (quoted) {
      taken.text = first.text;
      line.remove_prefix(line.find('"', static_cast<std::size_t>(first.text.data() + first.text.size() - line.data())) + 1);
    }
  }
  const std::size_t end = blanks ? line.find_first_of(" \t\r") : line.find(dialect_.delimiter);
  if (!quoted) taken.text = line.substr(0, end);
  while (!quoted && !taken.text.empty() && (taken.text.back() == ' ' || taken.text.back() == '\r' || taken.text.back() == '\t'))
    taken.text.remove_suffix(1);
  taken.more = end != std::string_view::npos;
  line.remove_prefix(taken.more ? end + 1 : line.size());
  return taken;
}

void LineRewriter::add_line(std::string_view line, std::string& out) {
  const std::size_t begin = out.size();
  const char delimiter = dialect_.delimiter;
  const auto skip_blanks = [&] {
    while (!line.empty() && (line.front() == ' ' || line.front() == '\r' || (line.front() == '\t' && delimiter != '\t'))) line.remove_prefix(1);
  };
  skip_blanks();
  if (line.starts_with('#')) return void(out.append(line));
  date_ = {}, joined_ = false;
  for (std::size_t index = 0;; ++index) {
    skip_blanks();
    if (delimiter == ' ' && line.empty()) return;
    const Taken field = take_field(line);
    const bool is_joined = std::exchange(joined_, false);  // with the field before, which has the sum
    if (index > 0 && !is_joined) out.push_back(delimiter);
    if (dialect_.use(index) == FieldUse::sensor && is_of_another_sensor(field.text)) return out.resize(begin);
    if (!is_joined) add_field(field.text, index, line, out);
    if (!field.more) return;
  }
}

bool LineRewriter::is_of_another_sensor(std::string_view name) const {
  return !sensor_.empty() && name != sensor_ && std::find(dialect_.sensors.begin(), dialect_.sensors.end(), name) != dialect_.sensors.end();
}

void LineRewriter::add(std::string_view lines, std::string& out) {
  out.reserve(out.size() + lines.size() + lines.size() / 8);
  const bool only_numbers = dialect_.uses.empty() && dialect_.delimiter != ' ';
  while (!lines.empty()) {
    std::size_t end = only_numbers ? append_numbers(lines, dialect_, out) : 0;
    if (end == 0) {
      end = std::min(lines.find('\n'), lines.size());
      std::string_view line = lines.substr(0, end);
      if (line.ends_with('\r')) line.remove_suffix(1);
      add_line(line, out);
    }
    if (end < lines.size()) out.push_back('\n');
    lines.remove_prefix(std::min(end + 1, lines.size()));
  }
}

}  // namespace imulab::recording_io
