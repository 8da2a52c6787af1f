// Text of files and of command lines as people see it: what would steer a terminal is shown, not obeyed.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace imulab {

/// `text` with control characters (all but line ends and tabs), marks that change the direction of writing, and bytes that are not UTF-8 as "\x1b".
std::string printable(std::string_view text);

/// A name or a value of a file in a message: as above, on one line, and cut to that many characters.
std::string excerpt(std::string_view text, std::size_t most = 60);

}  // namespace imulab
