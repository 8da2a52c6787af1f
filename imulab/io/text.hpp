// Small pieces of text that readers' messages are made of.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace imulab {

/// "a, b, c"
std::string listed(const std::vector<std::string_view>& names);

/// The name nearest to `word`, where a slip of the fingers may part them; else empty.
std::string_view nearest_name(std::string_view word, const std::vector<std::string_view>& names);

}  // namespace imulab
