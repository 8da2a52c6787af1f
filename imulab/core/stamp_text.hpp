// Times as text: of a recording's clock, and dates. Clocks that count from 1970 have ten digits before the point: fewer would name another sample.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace imulab {

/// Seconds to the microsecond, without trailing zeros: "1700000000.01", "-0.5", "3".
std::string stamp_text(double seconds);

/// Nanoseconds as seconds, exactly: "1700000000.000000001".
std::string stamp_text(std::int64_t ns);

/// Seconds since 1970 of a text that is a date, or a date and time (UTC, "2026-03-31T12:00:00Z"); none for any other text.
std::optional<double> time_of(const std::string& text);

/// A date alone: "2026-03-31".
bool is_date(const std::string& text);

}  // namespace imulab
