// How a number is written: its decimal mark, and what divides its thousands.
#pragma once

#include <string_view>

namespace imulab::recording_io {

/// What one field shows. "1.234,5" has a decimal comma and points between thousands; "1,234" is one or the other; "9.81" has a decimal point.
struct NumberForm {
  bool number = false;  ///< in some convention; also nan and inf
  bool decimal_comma = false, decimal_point = false;
  bool comma_groups = false, point_groups = false;    ///< between thousands
  bool comma_unknown = false, point_unknown = false;  ///< a decimal mark before three digits, or between thousands
  char groups = 0;                                    ///< another sign between thousands: ' ' (also the one that does not break), '\''
};

NumberForm number_form(std::string_view field);

/// The bytes of a sign between thousands that is none of ',' and '.': a blank (plain, no-break, narrow), an apostrophe (plain, typographic); 0: none.
std::size_t group_sign(std::string_view text, char& kind);

}  // namespace imulab::recording_io
