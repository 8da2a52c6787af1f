// Numbers as text at the end of a string, as fmt writes them and four times as fast: for files of millions of rows.
#pragma once

#include <string>

namespace imulab::text {

/// "{:.Nf}" of fmt, `decimals` from 0 to 15.
void append_fixed(std::string& to, double value, int decimals);
/// "{:.4g}" of fmt.
void append_four_digits(std::string& to, double value);

}  // namespace imulab::text
