#include "imulab/core/stated_limit.hpp"

#include "imulab/core/nearest_name.hpp"
#include "imulab/core/text.hpp"
#include "imulab/core/unit_expression.hpp"
#include "imulab/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>

namespace imulab {
namespace {

constexpr std::string_view limit_blanks = " \t\n";

/// A number above 0 at the begin of `text`, which it is taken from.
double take_limit(std::string_view& text, const std::string& stated) {
  double number = 0;
  if (is_decimal_comma(text, text.find(','))) throw Error(stated + ": has a decimal comma; expected a point, as in 0.5");
  const char* const end = text.data() + text.size();
  const auto [after, failure] = std::from_chars(text.data(), end, number);
  if (failure != std::errc() || !(number > 0) || !std::isfinite(number)) throw Error(stated + ": expected a number above 0");
  text = trimmed({after, static_cast<std::size_t>(end - after)}, limit_blanks);
  return number;
}

StatedLimit parse_limit(std::string_view text, std::string_view form, std::string_view example) {
  const auto sign = std::min(text.find("<="), text.find("≤"));
  if (sign == std::string_view::npos) throw Error(fmt::format("\"{}\": expected {}, as in \"{}\"", trimmed(text, limit_blanks), form, example));
  StatedLimit out;
  out.name = trimmed(text.substr(0, sign), limit_blanks);
  std::string_view rest = trimmed(text.substr(sign + (text[sign] == '<' ? 2 : std::string_view("≤").size())), limit_blanks);
  const std::string stated = fmt::format("{} <= {}", out.name, rest);
  out.number = take_limit(rest, stated);
  if (const auto at = rest.find(" at "); at != std::string_view::npos) {
    std::string_view time = trimmed(rest.substr(at + 4), limit_blanks);
    rest = trimmed(rest.substr(0, at), limit_blanks);
    out.at_s = take_limit(time, stated);
    if (time != "s") throw Error(fmt::format("{}: \"{}\" is no unit of this time; expected s", stated, time));
  }
  out.unit = rest;
  return out;
}

}  // namespace

bool is_decimal_comma(std::string_view text, std::size_t at) {
  constexpr std::string_view digits = "0123456789";
  if (at >= text.size() || at + 1 == text.size() || text[at] != ',' || digits.find(text[at + 1]) == std::string_view::npos) return false;
  const std::string_view before = text.substr(0, at);
  const std::size_t last = before.find_last_not_of(digits);  // the "^" of "m/s^2,95 %" is no begin of a number
  return before.size() > (last == std::string_view::npos ? 0 : last + 1) &&
         (last == std::string_view::npos || std::string_view(" \t\n=<+-").find(before[last]) != std::string_view::npos);
}

std::string to_string(const StatedLimit& limit) {
  return fmt::format("{} <= {:g}{}{}{}", limit.name, limit.number, limit.unit.empty() ? "" : " ", limit.unit,
                     limit.at_s ? fmt::format(" at {:g} s", *limit.at_s) : "");
}

std::vector<StatedLimit> parse_limits(std::string_view text, std::string_view form, std::string_view example) {
  std::vector<StatedLimit> out;
  for (std::size_t begin = 0; begin <= text.size();) {
    std::size_t end = std::min(text.find(',', begin), text.size());
    while (is_decimal_comma(text, end)) end = std::min(text.find(',', end + 1), text.size());
    out.push_back(parse_limit(text.substr(begin, end - begin), form, example));
    begin = end + 1;
  }
  return out;
}

namespace {

std::string plain_name(std::string_view name) {
  std::string out;
  for (const char c : name)
    if (c != ' ') out += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

void add_once(std::vector<std::string>& names, const std::string& name) {
  if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
}

}  // namespace

FoundFigure find_figure(const StatedLimit& limit, const std::vector<StatedFigure>& figures) {
  std::vector<std::string> names, units;
  for (std::size_t i = 0; i < figures.size(); ++i) {
    add_once(names, figures[i].name);
    if (plain_name(figures[i].name) != plain_name(limit.name)) continue;
    for (const StatedUnit& unit : figures[i].units) {
      if (unit.name == limit.unit) return {i, limit.number * unit.size};
      if (const auto size = size_of_unit_like(limit.unit, unit.name, unit.size)) return {i, limit.number * *size};
      add_once(units, unit.name);
    }
  }
  if (units.empty()) throw Error(fmt::format("{}: no figure of this result{}", limit.name, expected_name(limit.name, names)));
  if (limit.unit.empty()) throw Error(fmt::format("{}: no unit after the number; expected one of {}", to_string(limit), fmt::join(units, ", ")));
  throw Error(fmt::format("{}: \"{}\" is no unit of {}{}", to_string(limit), limit.unit, limit.name, expected_name(limit.unit, units)));
}

}  // namespace imulab
