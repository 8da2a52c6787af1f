// The constants of OutlierFilter in C source.
#pragma once

#include <string>
#include <string_view>

namespace imulab::firmware {

/// `source` with the numbers in the places @LEARNING@, @MEMORY@, @FACTOR@ and @RESOLUTIONS@.
std::string with_filter_constants(std::string_view source);

}  // namespace imulab::firmware
