#include "imulab/formats/recording/text/labels.hpp"

#include "imulab/core/text.hpp"
#include "imulab/formats/recording/text/number_form.hpp"
#include "imulab/formats/text/date.hpp"
#include "imulab/formats/text/take_until.hpp"
#include "imulab/inspection/names.hpp"

#include <algorithm>
#include <cstddef>
#include <map>
#include <utility>

namespace imulab::recording_io {
namespace {

constexpr std::string_view dividers = " \t\r,;|()[]<>{}";

bool is_digit_at(std::string_view text, std::size_t i) { return i < text.size() && text[i] >= '0' && text[i] <= '9'; }

bool is_whole(std::string_view number) { return number.find_first_not_of("0123456789") == std::string_view::npos; }

std::string_view inside(std::string_view text) { return trimmed(text, dividers); }

/// The place of the next = or : that stands behind a name, and not inside a time of day.
std::size_t find_mark(std::string_view text) {
  for (std::size_t i = text.find_first_of("=:"); i != std::string_view::npos; i = text.find_first_of("=:", i + 1))
    if (text[i] == '=' || i == 0 || !is_digit_at(text, i - 1) || !is_digit_at(text, i + 1)) return i;
  return std::string_view::npos;
}

/// Takes a number off the front, with what stands before it; empty where something else comes first.
std::string_view take_number(std::string_view& text) {
  const std::size_t first = std::min(text.find_first_not_of(dividers), text.size());
  const std::string_view rest = text.substr(first);
  const std::size_t end = std::min(rest.find_first_not_of("+-.0123456789eE"), rest.size());
  if (end < rest.size() && dividers.find(rest[end]) == std::string_view::npos && end > 0 && (rest[end - 1] == 'e' || rest[end - 1] == 'E')) return {};
  std::string_view number = rest.substr(0, end);
  if (rest.starts_with("nan") || rest.starts_with("NaN")) number = rest.substr(0, 3);
  if (!number_form(number).number) return {};
  text.remove_prefix(first + number.size());
  return number;
}

/// A stamp before the first label: "19:34:18.499 ->", "[12.5]", a date and a time.
void take_stamp(std::string_view& text, LabeledLine& line) {
  const std::size_t begin = std::min(text.find_first_not_of(dividers), text.size());
  const std::string_view rest = text.substr(begin);
  const auto word_end = [&](std::size_t from) { return std::min(rest.find_first_of(" \t,;|]>-", from), rest.size()); };
  for (std::size_t end : {std::min(rest.find(' ', std::min(rest.find(' ') + 1, rest.size())), rest.size()),
                          std::min(rest.find_first_of(" \t,;|]>"), rest.size()), word_end(0)}) {
    const std::string_view stamp = rest.substr(0, end);
    const bool number = number_form(stamp).number;
    if (!number && !text::moment_of(stamp)) continue;
    line.names.emplace_back("time");
    line.units.emplace_back();
    line.values.emplace_back(stamp);
    text.remove_prefix(begin + end);
    if (const std::size_t label = text.find_first_not_of(" \t,;|]>-"); label != std::string_view::npos) text.remove_prefix(label);
    return;
  }
}

/// What stands between a number and the next label's mark: a unit, and that label's name.
std::pair<std::string_view, std::string_view> unit_and_name(std::string_view text) {
  const std::size_t divided = text.find_last_of("\t,;|)]");
  if (divided != std::string_view::npos) return {inside(text.substr(0, divided)), inside(text.substr(divided + 1))};
  const std::string_view words = inside(text);
  const std::size_t blank = words.find(' ');
  if (blank == std::string_view::npos || inspection::unit_of(words.substr(0, blank)).empty()) return {{}, words};
  return {words.substr(0, blank), inside(words.substr(blank))};
}

/// The place of the arrow behind a stamp, in front of the fields of a table.
std::size_t find_arrow(std::string_view line) {
  const std::size_t arrow = line.find("->");
  if (arrow == std::string_view::npos) return arrow;
  const std::string_view stamp = inside(line.substr(0, arrow));
  return number_form(stamp).number || text::moment_of(stamp) ? arrow : std::string_view::npos;
}

/// A stamp is a field before the others; before a header, its name.
void add_stamped(std::string_view line, char divider, std::string& out) {
  const std::size_t arrow = find_arrow(line);
  if (arrow == std::string_view::npos) return void(out.append(line));
  const std::string_view fields = inside(line.substr(arrow + 2));
  const bool numbers = !fields.empty() && number_form(inside(fields.substr(0, fields.find(divider)))).number;
  out.append(numbers ? inside(line.substr(0, arrow)) : "time");
  out.push_back(divider);
  out.append(fields);
}

}  // namespace

std::optional<LabeledLine> labeled_line(std::string_view text) {
  constexpr std::size_t most = 256;  // numbers
  LabeledLine line;
  take_stamp(text, line);
  const std::size_t stamps = line.values.size();
  std::size_t mark = find_mark(text);
  if (mark == std::string_view::npos) return std::nullopt;
  std::string name(inside(text.substr(0, mark)));
  while (true) {
    if (name.empty() || is_digit_at(name, 0)) return std::nullopt;
    text.remove_prefix(mark + 1);
    const std::size_t before = line.values.size();
    while (line.values.size() < most) {
      const bool joined = text.starts_with(',') && text.size() > 1 && text[1] != ' ';
      const std::string_view number = take_number(text);
      if (number.empty()) break;
      const bool one_more = line.values.size() == before + 1 && !text.starts_with(',');
      if (joined && one_more && is_whole(number) && line.values.back().find('.') == std::string::npos)
        return std::nullopt;  // "X=1,5" may be one number
      line.values.emplace_back(number);
    }
    const std::size_t count = line.values.size() - before;
    if (count == 0) return std::nullopt;
    mark = find_mark(text);
    const auto [unit, next] = mark == std::string_view::npos ? std::pair{inside(text), std::string_view{}} : unit_and_name(text.substr(0, mark));
    for (std::size_t i = 1; i <= count; ++i) line.names.push_back(count == 1 ? name : name + "." + std::to_string(i)), line.units.emplace_back(unit);
    if (mark == std::string_view::npos) break;
    name = next;
  }
  return line.values.size() >= stamps + 2 ? std::optional(std::move(line)) : std::nullopt;
}

Labels::Labels(std::string_view head) {
  constexpr std::size_t looked_at = 100, enough = 3;  // lines
  if (head.substr(0, std::size_t{1} << 16).find_first_of("=:>") == std::string_view::npos) return;
  std::map<std::vector<std::string>, std::pair<std::size_t, std::vector<std::string>>> counts;
  std::size_t lines = 0, stamped = 0;
  char divider = ' ';
  for (; !head.empty() && lines < looked_at; ++lines) {
    const std::string_view own = text::take_until(head, '\n');
    if (own.size() >= 4096) continue;
    if (find_arrow(own) != std::string_view::npos) {
      ++stamped;
      for (const char c : {';', ',', '\t'})
        if (divider == ' ' && own.find(c) != std::string_view::npos) divider = c;
    }
    if (auto line = labeled_line(own)) {
      auto& [count, units] = counts[line->names];
      if (count++ == 0) units = std::move(line->units);
    }
  }
  for (auto& [names, found] : counts)
    if (found.first >= enough && 2 * found.first > lines) names_ = names, units_ = std::move(found.second);
  if (names_.empty() && stamped >= enough && 2 * stamped > lines) divider_ = divider;
}

void Labels::add(std::string_view lines, std::string& out) const {
  while (!lines.empty()) {
    const bool whole = lines.find('\n') != std::string_view::npos;
    const std::string_view own = text::take_until(lines, '\n');
    const auto line = divider_ != 0 ? std::nullopt : labeled_line(own);
    if (divider_ != 0) {
      add_stamped(own, divider_, out);
    } else if (line && line->names == names_) {
      for (std::size_t i = 0; i < line->values.size(); ++i) {
        if (i > 0) out.push_back(',');
        out.append(line->values[i]);
      }
    } else {
      out.append(own);
    }
    if (whole) out.push_back('\n');
  }
}

}  // namespace imulab::recording_io
