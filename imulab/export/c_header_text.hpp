// Pieces of C source.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

namespace imulab::firmware {

constexpr std::array<const char*, 3> axis_names{"x", "y", "z"};

/// As a literal of the header's number type, exact in double. Throws Error where it is not finite.
std::string literal(double value);
/// An integer constant of up to 62 bits that every C and C++ reads, C++98 included.
std::string literal(std::int64_t value);

/// A text from outside for a comment or between quotes: one line of ASCII that ends neither; other characters become '_', and a long one is cut.
std::string harmless(std::string_view text);

/// A unit as part of a name: "deg/s" is "deg_per_s".
std::string unit_in_name(std::string_view unit);

}  // namespace imulab::firmware
