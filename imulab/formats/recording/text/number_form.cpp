#include "imulab/formats/recording/text/number_form.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

namespace imulab::recording_io {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

std::size_t leading_digits(std::string_view text) {
  return static_cast<std::size_t>(std::find_if_not(text.begin(), text.end(), is_digit) - text.begin());
}

bool is_word_of_number(std::string_view text) {
  static constexpr std::array<std::string_view, 8> words{"nan", "NaN", "NAN", "inf", "Inf", "INF", "infinity", "Infinity"};
  return std::find(words.begin(), words.end(), text) != words.end();
}

/// "e-05" at the end; takes it off. False where an e has no number.
bool take_exponent(std::string_view& text, bool& found) {
  const std::size_t e = text.find_first_of("eE");
  found = e != std::string_view::npos;
  if (!found) return true;
  std::string_view exponent = text.substr(e + 1);
  if (exponent.starts_with('+') || exponent.starts_with('-')) exponent.remove_prefix(1);
  text = text.substr(0, e);
  return !exponent.empty() && exponent.size() <= 4 && leading_digits(exponent) == exponent.size();
}

/// The marks of a mantissa and what stands between them.
struct Marks {
  std::size_t commas = 0, points = 0;
  char last = 0, groups = 0;
  bool grouped = true;     ///< all marks but the last have three digits behind them, and one to three stand before the first
  std::size_t first = 0;   ///< digits before the first mark
  std::size_t behind = 0;  ///< digits behind the last mark
  bool good = true;
};

Marks marks_of(std::string_view text) {
  Marks marks;
  marks.first = leading_digits(text);
  marks.grouped = marks.first >= 1 && marks.first <= 3;
  text.remove_prefix(marks.first);
  while (!text.empty()) {
    char kind = 0;
    const std::size_t other = group_sign(text, kind);
    if (marks.last != 0) marks.grouped = marks.grouped && marks.behind == 3;
    if (other > 0) {
      marks.good = marks.good && (marks.groups == 0 || marks.groups == kind) && marks.commas + marks.points == 0;
      marks.groups = marks.last = kind;
    } else if (text.front() == ',' || text.front() == '.') {
      marks.last = text.front();
      ++(marks.last == ',' ? marks.commas : marks.points);
    } else {
      marks.good = false;
    }
    if (!marks.good) return marks;
    text.remove_prefix(std::max<std::size_t>(1, other));
    marks.behind = leading_digits(text);
    text.remove_prefix(marks.behind);
  }
  return marks;
}

/// One mark alone: "0.5", "9,812"; of each kind what it shows.
void judge_alone(const Marks& m, bool zero, bool exponent, bool& decimal, bool& unknown) {
  unknown = !zero && !exponent && m.first >= 1 && m.first <= 3 && m.behind == 3;
  decimal = !unknown;
}

}  // namespace

std::size_t group_sign(std::string_view text, char& kind) {
  static constexpr std::array<std::pair<std::string_view, char>, 6> signs{
      {{" ", ' '}, {"\xC2\xA0", ' '}, {"\xE2\x80\xAF", ' '}, {"\xE2\x80\x89", ' '}, {"'", '\''}, {"\xE2\x80\x99", '\''}}};
  for (const auto& [sign, kind_of_it] : signs)
    if (text.starts_with(sign)) return kind = kind_of_it, sign.size();
  return 0;
}

NumberForm number_form(std::string_view field) {
  NumberForm form;
  if (field.starts_with('+') || field.starts_with('-')) field.remove_prefix(1);
  if (is_word_of_number(field)) return form.number = true, form;
  bool exponent = false;
  if (field.empty() || field.size() > 64 || !take_exponent(field, exponent) || field.find_first_of("0123456789") == std::string_view::npos)
    return form;
  const Marks m = marks_of(field);
  if (!m.good) return form;
  const bool zero = field.front() == '0';
  if (m.groups != 0) {
    if (!m.grouped || m.commas + m.points > 1 || (m.commas + m.points == 0 && m.behind != 3)) return form;
    form.groups = m.groups;
    form.decimal_comma = m.commas == 1, form.decimal_point = m.points == 1;
  } else if (m.commas > 0 && m.points > 0) {
    if ((m.last == ',' ? m.commas : m.points) != 1 || !m.grouped) return form;
    (m.last == ',' ? form.decimal_comma : form.decimal_point) = true;
    (m.last == ',' ? form.point_groups : form.comma_groups) = true;
  } else if (m.commas > 1 || m.points > 1) {
    if (!m.grouped || m.behind != 3 || zero) return form;
    (m.commas > 1 ? form.comma_groups : form.point_groups) = true;
  } else if (m.commas == 1) {
    if (m.behind == 0) return form;  // "1," of a list
    judge_alone(m, zero, exponent, form.decimal_comma, form.comma_unknown);
  } else if (m.points == 1) {
    judge_alone(m, zero, exponent, form.decimal_point, form.point_unknown);
  }
  form.number = true;
  return form;
}

}  // namespace imulab::recording_io
