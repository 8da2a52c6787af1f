// Dates and times of day as people and spreadsheets write them, exactly: without floating point in between.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace imulab::text {

/// The order of the two numbers in 03/04/2025.
enum class DateOrder { unknown, day_first, month_first };

struct Moment {
  bool has_date = false, has_time = false;
  DateOrder shows = DateOrder::unknown;  ///< of a date that can be read in one order alone
  bool ordered = false;                  ///< the date needs an order: 03/04/2025
  std::int64_t seconds = 0;              ///< since 1970 (UTC unless a zone is written), or since midnight
  std::string_view fraction{};           ///< the digits behind the point

  explicit operator bool() const { return has_date || has_time; }
};

/// "2025-07-08T19:34:18.499+02:00", "2025/07/08 19:34:18.499", "08.07.2025 19:34", "08-Jul-2025 19:34:18", "7/8/2025 7:34:18 PM",
/// a date alone, a time of day alone (two colons). Nothing for any other text. Years 1970 to 2261. `order`: of dates that need one.
Moment moment_of(std::string_view text, DateOrder order = DateOrder::unknown);

/// Seconds with their fraction, as a decimal number: "1751999658.499".
void append_seconds(std::string& out, std::int64_t seconds, std::string_view fraction);

}  // namespace imulab::text
