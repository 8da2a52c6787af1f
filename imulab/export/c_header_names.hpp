// The names of an exported header, and what keeps two headers with the same names apart.
#pragma once

#include <string>
#include <string_view>

namespace imulab::firmware {

/// Throws Error where names that begin with it would not be C's and C++'s to give: expected are letters, digits and single underscores between them,
/// a letter first.
void expect_prefix(std::string_view prefix);

/// As the header's macros begin: "IMU1" of "imu1".
std::string macro_prefix(std::string_view prefix);

/// C source in which every name that begins with imulab_ or IMULAB_ begins with the prefix instead.
std::string with_prefix(std::string_view source, std::string_view prefix);

/// The comment and the source of a header with its guards: it may be included twice, but another one with the same prefix is a compile error, since
/// either would be used for both IMUs.
std::string guarded(const std::string& comment, const std::string& source, std::string_view prefix);

}  // namespace imulab::firmware
