#include "imulab/formats/text/time.hpp"

#include "imulab/core/error.hpp"

#include <fmt/format.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>

namespace imulab {

std::string time_text(double time) {
  constexpr double latest = 253402300799.0;  // of the year 9999
  if (!(time > -latest && time <= latest)) return "";
  const auto seconds = static_cast<std::time_t>(std::floor(time));
  std::tm parts{};
  std::array<char, 32> text;
  gmtime_r(&seconds, &parts);
  return {text.data(), std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &parts)};
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

double parse_time(const std::string& text) {
  if (const std::optional<double> time = time_of(text)) return *time;
  throw Error(fmt::format("{}: is no time; expected UTC as in 2026-03-31 or 2026-03-31T12:00:00Z", text));
}

}  // namespace imulab
