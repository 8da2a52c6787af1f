// The name that was meant where a word is none of those that are known.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace imulab {

/// The shortest name that begins with `word`, where that has three letters; else the name with the fewest edits (insert, delete or replace a letter)
/// from it, if they are few enough for a typing error; else empty.
std::string_view nearest_name(std::string_view word, const std::vector<std::string_view>& names);

/// The end of a message about such a word: "; did you mean handheld?", or nothing.
std::string did_you_mean(std::string_view word, const std::vector<std::string_view>& names);
std::string did_you_mean(std::string_view word, const std::vector<std::string>& names);

/// The same, and without such a name "; expected one of handheld, static".
std::string expected_name(std::string_view word, const std::vector<std::string_view>& names);
std::string expected_name(std::string_view word, const std::vector<std::string>& names);

}  // namespace imulab
