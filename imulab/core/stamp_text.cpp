#include "imulab/core/stamp_text.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <cstdio>

namespace imulab {

namespace {

/// A number with decimals, without those at its end that are zero.
std::string shortest(std::string text) {
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text == "-0" ? "0" : text;
}

}  // namespace

std::string stamp_text(double seconds) {
  constexpr double largest = 1e15;  // beyond it a double has no decimals
  return std::abs(seconds) < largest ? shortest(fmt::format("{:.6f}", seconds)) : fmt::format("{:g}", seconds);
}

std::string stamp_text(std::int64_t ns) {
  constexpr std::uint64_t second = 1'000'000'000;
  const std::uint64_t size = ns < 0 ? 0 - static_cast<std::uint64_t>(ns) : static_cast<std::uint64_t>(ns);
  return shortest(fmt::format("{}{}.{:09}", ns < 0 ? "-" : "", size / second, size % second));
}

std::optional<double> time_of(const std::string& text) {
  namespace chrono = std::chrono;
  int y = 0, mo = 0, d = 0, h = 0, mi = 0, s = 0, length = 0;
  const bool date_only = std::sscanf(text.c_str(), "%4d-%2d-%2d%n", &y, &mo, &d, &length) == 3 && text.size() == static_cast<std::size_t>(length);
  const bool whole = date_only || (std::sscanf(text.c_str(), "%4d-%2d-%2dT%2d:%2d:%2dZ%n", &y, &mo, &d, &h, &mi, &s, &length) == 6 &&
                                   text.size() == static_cast<std::size_t>(length));
  const chrono::year_month_day date{chrono::year(y), chrono::month(static_cast<unsigned>(mo)), chrono::day(static_cast<unsigned>(d))};
  if (!whole || !date.ok() || h < 0 || h > 23 || mi < 0 || mi > 59 || s < 0 || s > 60) return std::nullopt;
  return static_cast<double>(chrono::sys_days(date).time_since_epoch().count()) * 86400.0 + 3600.0 * h + 60.0 * mi + s;
}

bool is_date(const std::string& text) { return text.size() == 10 && time_of(text).has_value(); }

}  // namespace imulab
