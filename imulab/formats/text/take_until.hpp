// Texts in parts: lines, and fields of lines.
#pragma once

#include <algorithm>
#include <string_view>

namespace imulab::text {

/// Takes what stands before the next `end` off the front, and `end` itself; all of the text where there is none.
inline std::string_view take_until(std::string_view& text, char end) {
  const std::string_view part = text.substr(0, text.find(end));
  text.remove_prefix(std::min(part.size() + 1, text.size()));
  return part;
}

}  // namespace imulab::text
