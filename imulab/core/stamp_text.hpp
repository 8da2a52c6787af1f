// A time of a recording's clock as text. Clocks that count from 1970 have ten digits before the point: fewer digits would name another sample.
#pragma once

#include <cstdint>
#include <string>

namespace imulab {

/// Seconds to the microsecond, without trailing zeros: "1700000000.01", "-0.5", "3".
std::string stamp_text(double seconds);

/// Nanoseconds as seconds, exactly: "1700000000.000000001".
std::string stamp_text(std::int64_t ns);

}  // namespace imulab
