// Numbers with their uncertainties, and sentences, for a terminal of 80 columns.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace imulab::text {

inline constexpr std::size_t terminal_width = 80;

/// An uncertainty with two significant digits: "0.031", "110", "1.2e-07". "-" where it is not finite.
std::string two_digits(double uncertainty);

/// A value to the decimal place of its uncertainty's second significant digit: 34.3034 with 0.0314 is "34.303". Six significant digits where the
/// uncertainty is zero or not finite.
std::string to_digits_of(double uncertainty, double value);

/// A number with this many significant digits, and without a power of ten where none is needed: "1360", "0.0873", "3.12e-06".
std::string number(double value, int digits = 3);

/// "1 unit", "3 units"
std::string plural(std::size_t count, std::string_view word);

/// "14 min 05 s"
std::string minutes(double seconds);

/// `sentence` in lines of at most `width` columns: the first begins with `first`, the others with as many spaces. Ends with a new line. Words longer
/// than a line stay whole. Counts code points of UTF-8.
std::string wrapped(std::string_view first, std::string_view sentence, std::size_t width = terminal_width);

/// `left` at the begin and `right` at the end of this many characters, or of as many as they need with a blank between them.
std::string two_ends(std::string_view left, std::string_view right, std::size_t width);

}  // namespace imulab::text
