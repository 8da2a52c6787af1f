// Dates and times of day, UTC. Times are seconds since 1970.
#pragma once

#include <optional>
#include <string>

namespace imulab {

/// "2026-03-31T12:00:00Z"; empty beyond the year 9999.
std::string time_text(double time);
/// Of a date, or of a date and time; none of what is neither.
std::optional<double> time_of(const std::string& text);
/// The same; throws Error.
double parse_time(const std::string& text);

}  // namespace imulab
