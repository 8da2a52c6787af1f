// JSON values as text.
#pragma once

#include <string>

namespace imulab {

/// Indented by this number of columns; -1: on one line. The name of a file may be any bytes: those that are not UTF-8 become U+FFFD.
template <class Json>
std::string dump_json(const Json& value, int indent = 2) {
  return value.dump(indent, ' ', false, Json::error_handler_t::replace);
}

}  // namespace imulab
