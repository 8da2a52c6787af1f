// Text of files and of command lines as people see it: what would steer a terminal is shown, not obeyed.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

/// `text` with control characters (all but line ends and tabs), marks that change the direction of writing, and bytes that are not UTF-8 as "\x1b".
std::string printable(std::string_view text);

/// The same on one line: line ends and tabs, too. For names in tables, where they would open a row or a column.
std::string one_line(std::string_view text);

/// Text within the quotes of JSON or TOML: marks and controls beyond ASCII that `printable` shows become escapes there, which mean the same.
std::string with_escapes(std::string_view text);

/// A name or a value of a file in a message: as above, on one line, and cut to that many characters.
std::string excerpt(std::string_view text, std::size_t most = 60);

}  // namespace imulab

namespace imulab::text {

// Lists of names in messages.

/// "a, b, c"
std::string listed(const std::vector<std::string_view>& names);

/// Names from a file in such a list, cut as `excerpt` does; "..." for those after the twentieth.
std::string listed_excerpts(const std::vector<std::string>& names);

/// About a name that is none of those of a file: "; expected one of gx, gy; did you mean gx?".
std::string expected_excerpt(std::string_view name, const std::vector<std::string>& names);

}  // namespace imulab::text
