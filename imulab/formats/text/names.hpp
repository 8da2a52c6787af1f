// Lists of names in messages.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace imulab::text {

/// "a, b, c"
std::string listed(const std::vector<std::string_view>& names);

/// The same of names from a file, cut as `excerpt` does; "..." for those after the twentieth.
std::string listed_excerpts(const std::vector<std::string>& names);

/// The name with the fewest edits (insert, delete or replace a letter) from `word`, if they are few enough for a typing error; else empty.
std::string_view nearest_name(std::string_view word, const std::vector<std::string_view>& names);

}  // namespace imulab::text
