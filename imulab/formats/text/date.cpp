#include "imulab/formats/text/date.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <utility>

namespace imulab::text {
namespace {

bool is_date_digit(char c) { return c >= '0' && c <= '9'; }

/// Takes a text apart from its front.
class Scanner {
 public:
  explicit Scanner(std::string_view text) : text_(text) {}

  std::string_view rest() const { return text_; }
  bool done() const { return text_.empty(); }
  bool take(char c) {
    if (!text_.starts_with(c)) return false;
    text_.remove_prefix(1);
    return true;
  }
  bool take_any(std::string_view characters) {
    return !text_.empty() && characters.find(text_.front()) != std::string_view::npos && take(text_.front());
  }
  /// Digits, `least` to `most` of them; empty where there are fewer, or more.
  std::string_view digits(std::size_t least, std::size_t most) {
    const auto end = static_cast<std::size_t>(std::find_if_not(text_.begin(), text_.end(), is_date_digit) - text_.begin());
    if (end < least || end > most) return {};
    const std::string_view taken = text_.substr(0, end);
    text_.remove_prefix(end);
    return taken;
  }
  /// Exactly so many digits, whatever follows; empty where there are fewer.
  std::string_view exactly(std::size_t count) {
    if (text_.size() < count || !std::all_of(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(count), is_date_digit)) return {};
    const std::string_view taken = text_.substr(0, count);
    text_.remove_prefix(count);
    return taken;
  }
  /// The number of a month's name, from 1; 0 where there is none.
  int month() {
    static constexpr std::array<std::string_view, 12> names{"jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec"};
    if (text_.size() < 3) return 0;
    std::array<char, 3> word{};
    std::transform(text_.begin(), text_.begin() + 3, word.begin(), [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
    const auto found = std::find(names.begin(), names.end(), std::string_view(word.data(), 3));
    if (found == names.end()) return 0;
    text_.remove_prefix(3);
    return static_cast<int>(found - names.begin()) + 1;
  }

 private:
  std::string_view text_;
};

int number(std::string_view digits) {
  int value = 0;
  std::from_chars(digits.data(), digits.data() + digits.size(), value);
  return value;
}

/// Adds the days of a date; false where there is none.
bool put_days(int year, int month, int day, Moment& moment) {
  using namespace std::chrono;
  const year_month_day date{std::chrono::year(year), std::chrono::month(static_cast<unsigned>(month)), std::chrono::day(static_cast<unsigned>(day))};
  if (year < 1970 || year > 2261 || !date.ok()) return false;
  moment.seconds += 86400 * std::int64_t{sys_days(date).time_since_epoch().count()};
  return moment.has_date = true;
}

/// Two numbers whose order is not written.
bool put_ordered(int first, int second, int year, DateOrder order, Moment& moment) {
  moment.ordered = true;
  if (first > 12) moment.shows = DateOrder::day_first;
  if (second > 12) moment.shows = DateOrder::month_first;
  if (moment.shows != DateOrder::unknown) order = moment.shows;
  return order == DateOrder::month_first ? put_days(year, first, second, moment) : put_days(year, second, first, moment);
}

bool take_date(Scanner& s, DateOrder order, Moment& moment) {
  if (const auto year = Scanner(s).exactly(4); !year.empty()) {
    s.exactly(4);
    for (const char between : {'-', '/', '.'})
      if (s.take(between)) {
        const auto month = s.digits(1, 2);
        if (month.empty() || !s.take(between)) return false;
        const auto day = s.digits(1, 2);
        return !day.empty() && put_days(number(year), number(month), number(day), moment);
      }
    const auto month = s.exactly(2), day = s.exactly(2);  // 20250708, before a T
    return !day.empty() && s.rest().starts_with('T') && put_days(number(year), number(month), number(day), moment);
  }
  const auto first = s.digits(1, 2);
  if (first.empty()) return false;
  for (const char between : {'/', '.', '-'})
    if (s.take(between)) {
      const int named = s.month();
      const auto second = named == 0 ? s.digits(1, 2) : std::string_view{};
      if ((named == 0 && second.empty()) || !s.take(between)) return false;
      const auto year = s.digits(4, 4);
      if (year.empty()) return false;
      if (named > 0) return put_days(number(year), named, number(first), moment);
      if (between == '.') return put_days(number(year), number(second), number(first), moment);  // dots stand behind days first, everywhere
      return put_ordered(number(first), number(second), number(year), order, moment);
    }
  return false;
}

/// "+02:00", "-0330", "+02", "Z", "UTC": the seconds by which the time is ahead.
bool take_zone(Scanner& s, Moment& moment) {
  while (s.take(' ')) {
  }
  if (s.done() || s.take('Z')) return true;
  if (s.rest() == "UTC" || s.rest() == "GMT") return s = Scanner({}), true;
  const bool east = s.rest().starts_with('+');
  if (!s.take_any("+-")) return false;
  const auto hours = s.exactly(2);
  s.take(':');
  const auto minutes = s.exactly(2);
  if (hours.empty() || number(hours) > 14 || (!minutes.empty() && number(minutes) > 59)) return false;
  const int ahead = 3600 * number(hours) + (minutes.empty() ? 0 : 60 * number(minutes));
  moment.seconds -= east ? ahead : -ahead;
  return true;
}

/// Hours, minutes, seconds, their fraction, AM or PM. Beside a date seconds may be missing.
bool take_time(Scanner& s, Moment& moment) {
  const auto hours = s.digits(1, 2);
  if (hours.empty() || !s.take(':')) return false;
  const auto minutes = s.exactly(2);
  if (minutes.empty()) return false;
  const bool has_seconds = s.take(':');
  const auto seconds = has_seconds ? s.exactly(2) : std::string_view{};
  if (has_seconds ? seconds.empty() : !moment.has_date) return false;
  if (has_seconds && (s.rest().starts_with('.') || s.rest().starts_with(',') || s.rest().starts_with(':'))) {
    s.take_any(".,:");
    moment.fraction = s.digits(1, 18);
    if (moment.fraction.empty()) return false;
  }
  int hour = number(hours);
  Scanner half = s;
  while (half.take(' ')) {
  }
  if (half.rest().size() >= 2 && (half.rest()[1] == 'M' || half.rest()[1] == 'm') && half.rest().find_first_of("APap") == 0) {
    if (hour < 1 || hour > 12) return false;
    hour = hour % 12 + (half.rest()[0] == 'P' || half.rest()[0] == 'p' ? 12 : 0);
    s = Scanner(half.rest().substr(2));
  }
  if (hour > 23 || number(minutes) > 59 || (has_seconds && number(seconds) > 60)) return false;
  moment.seconds += 3600 * hour + 60 * number(minutes) + (has_seconds ? number(seconds) : 0);
  return moment.has_time = true;
}

}  // namespace

Moment moment_of(std::string_view text, DateOrder order) {
  if (text.size() < 7 || text.size() > 48 || !is_date_digit(text.front())) return {};
  Moment moment;
  Scanner s(text);
  const std::size_t colon = text.find(':');
  if (colon == std::string_view::npos || colon > 2) {
    if (!take_date(s, order, moment)) return {};
    if (s.done()) return moment;
    if (!s.take_any("T_, ")) return {};
    while (s.take(' ')) {
    }
  }
  return take_time(s, moment) && take_zone(s, moment) && s.done() && moment.seconds >= 0 ? moment : Moment{};
}

void append_seconds(std::string& out, std::int64_t seconds, std::string_view fraction) {
  std::array<char, 24> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), seconds).ptr;
  out.append(digits.data(), end);
  if (!fraction.empty()) out.append(1, '.').append(fraction);
}

}  // namespace imulab::text
