#include "imulab/report/start.hpp"

#include "imulab/core/stamp_text.hpp"
#include "imulab/formats/text/decimal.hpp"
#include "imulab/formats/text/figures.hpp"

#include <fmt/format.h>

#include <cmath>

namespace imulab::report {

std::string date_text(double stamp) {
  constexpr double year_2000 = 946684800, year_2100 = 4102444800;
  if (!(stamp >= year_2000 && stamp < year_2100)) return {};
  const double ms = std::round(1e3 * stamp), seconds = std::floor(1e-3 * ms), fraction = ms - 1e3 * seconds;
  std::string text = time_text(seconds);
  if (fraction > 0) text.insert(text.size() - 1, fmt::format(".{:03.0f}", fraction));
  return text;
}

std::string stamp_and_date(double stamp) {
  const std::string date = date_text(stamp);
  return date.empty() ? stamp_text(stamp) + " s" : date;
}

std::string seconds_text(double duration) {
  const std::string text = text::number(duration, 6) + " s";
  return duration < 600 ? text : fmt::format("{} ({} min)", text, text::number(duration / 60, 3));
}

std::string time_label(double first, std::string_view unit) {
  const std::string name = fmt::format("time [{}]", unit), date = date_text(first);
  if (!date.empty()) return name + " from " + date;
  const std::string stamp = stamp_text(first);
  return stamp == "0" ? name : name + " from the start, at " + stamp + " s";
}

}  // namespace imulab::report
