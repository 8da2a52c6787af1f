// Letters and blanks of names and fields.
#pragma once

#include <string>
#include <string_view>

namespace imulab {

/// The text without blanks at its ends.
std::string_view trimmed(std::string_view text, std::string_view blanks = " \t\r");

/// With small letters in place of the capitals of ASCII.
std::string lowered(std::string_view text);

}  // namespace imulab
