#include "imulab/report/start.hpp"

#include "imulab/core/stamp_text.hpp"
#include "imulab/formats/text/decimal.hpp"
#include "imulab/formats/text/figures.hpp"

#include <fmt/format.h>

namespace imulab::report {

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
