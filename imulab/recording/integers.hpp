// Whole readings whose sign a file prints wrongly: -132 as 65404, or 65404 as -132.
#pragma once

#include "imulab/session.hpp"

#include <vector>

namespace imulab {

/// Brings whole numbers into the range of that kind of integer, by adding or subtracting 2^bits.
void take_as(Integers integers, std::vector<double>& column);

/// The kinds of integer that the columns of a table are, where the file prints them with the wrong sign; empty where it does not. A column is of a
/// kind if it jumps by nearly its whole range from one row to the next as printed, and by little as that kind. Another column is, too, if its numbers
/// are all in the top quarter of the unsigned range, and so negative; without any jump that takes a table all of whose columns keep to the quarters
/// next to 0 and to the range.
std::vector<Integers> integers_of(const std::vector<const std::vector<double>*>& columns);

}  // namespace imulab
